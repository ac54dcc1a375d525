// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/sheet_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"

namespace eha::report {
namespace {

constexpr double kRoundedCorner = 0.1;  // of the dead band: straight lines approximate rounded edges
constexpr double kCurvedGain = 0.05;    // of a gain
constexpr const char* kGain = "gain";
constexpr const char* kHalfDeadBand = "half dead band";
constexpr double kGainOfHalf = 2.0;  // [following] has half of each gain
constexpr double kWarmOil_V = 0.1;   // beyond what the intervals allow: no temperature moves a null so far

struct Value {
  double value = 0.0;
  double half_width = 0.0;  ///< of its 95 % interval
};

/// One quantity by the model and by the sheet.
struct Pair {
  std::string name = {};
  std::string unit = {};
  Value by_model = {};
  Value by_sheet = {};
  double rounding = 0.0;  ///< difference explained by the map's straight lines
  bool is_null = false;
  std::string in_file = {};  ///< how the file has the sheet's value, where it differs

  [[nodiscard]] double apart() const { return std::abs(by_model.value - by_sheet.value); }
  [[nodiscard]] double allowed() const { return std::hypot(by_model.half_width, by_sheet.half_width) + rounding; }
  [[nodiscard]] bool agrees() const { return apart() <= allowed(); }
};

std::optional<Value> by_model(const ident::Model& model, ident::ParameterRole role) {
  const auto at = std::find_if(model.parameters.begin(), model.parameters.end(), [&](const auto& parameter) {
    return parameter.role == role && !parameter.fixed && parameter.std > 0.0;
  });
  if (at == model.parameters.end()) return std::nullopt;
  return Value{at->value, ident::half_width95(*at)};
}

/// Returns the speed per volt of a plant K / (s (...)), or one with a pole nearly at 0; none for other plants.
std::optional<Value> gain_of(const ident::Model& model) {
  const auto gain = by_model(model, ident::ParameterRole::numerator_coefficient);
  const auto& g = model.transfer_function;
  const auto first = std::find_if(g.denominator.begin(), g.denominator.end(),
                                  [](const ident::Term& term) { return std::abs(term.order - 1.0) < 1e-9; });
  if (!gain || g.numerator.size() != 1 || g.numerator.front().order > 0.0 || first == g.denominator.end()) {
    return std::nullopt;
  }
  if (!(std::abs(first->coefficient) > 0.0)) return std::nullopt;
  return Value{gain->value / first->coefficient, gain->half_width / std::abs(first->coefficient)};
}

std::vector<Pair> pairs_of(const Subject& subject, const ident::Model& model) {
  const auto sheet = [&](const char* key) -> std::optional<double> {
    const auto& value = subject.part("rig", "following", key);
    return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
  };
  std::vector<Pair> pairs;
  const auto add = [&](Pair pair, const std::optional<Value>& of_model, std::optional<double> of_sheet,
                       std::optional<double> half_width) {
    if (!of_model || !of_sheet || !half_width) return;
    pair.by_model = *of_model;
    pair.by_sheet = {*of_sheet, *half_width};
    pairs.push_back(std::move(pair));
  };
  using Role = ident::ParameterRole;
  const double rounding = std::max(kRoundedCorner * model.input_map->dead_band,
                                   ident::kShiftOverMapError * ident::reported_map_error(model));
  add({.name = "null", .unit = model.input_unit, .rounding = rounding, .is_null = true},
      by_model(model, Role::valve_null), sheet("null_V"), sheet("null_uncertainty_V"));
  auto dead_band = sheet("dead_band_V");
  std::string in_file;
  if (dead_band) {
    in_file = fmt::format(" (dead_band_V = {:g} with {:g} V to spare)", *dead_band, record::kSpareOfFollowing_V);
    dead_band = std::max(0.0, *dead_band - record::kSpareOfFollowing_V);
  }
  add({.name = kHalfDeadBand, .unit = model.input_unit, .rounding = rounding, .in_file = in_file},
      by_model(model, Role::dead_band), dead_band, sheet("dead_band_uncertainty_V"));
  const auto positive = sheet("gain_positive_in_per_V_s");
  const auto negative = sheet("gain_negative_in_per_V_s");
  const auto share = sheet("gain_uncertainty_percent");
  if (!positive || !negative || !share) return pairs;
  const double ratio = *negative / *positive;
  add({.name = "negative gain ratio", .unit = "", .rounding = kCurvedGain * ratio},
      by_model(model, Role::negative_gain_ratio), ratio, std::sqrt(2.0) * 0.01 * *share * ratio);
  const double gain = kGainOfHalf * *positive * DisplayUnit(model.output_unit).factor("in");
  add({.name = kGain,
       .unit = fmt::format("{}/({} s)", model.output_unit, model.input_unit),
       .rounding = kCurvedGain * gain},
      gain_of(model), gain, 0.01 * *share * gain);
  return pairs;
}

/// Two figures of two digits, or of as many as it takes to tell them apart.
std::pair<std::string, std::string> told_apart(double a, double b) {
  constexpr int kMostDigits = 6;
  for (int digits = 2;; ++digits) {
    std::pair<std::string, std::string> both(fmt::format("{:.{}g}", a, digits), fmt::format("{:.{}g}", b, digits));
    if (both.first != both.second || digits == kMostDigits) return both;
  }
}

std::string shown(const Value& value, const std::string& unit) {
  return ident::with_half_width(value.value, value.half_width, "±") + (unit.empty() ? "" : " " + unit);
}

std::string differ_text(const Pair& pair) {
  const auto [apart, allowed] = told_apart(pair.apart(), pair.allowed());
  return fmt::format("they differ by {}, more than the {} that the intervals and the straight lines of the map allow",
                     apart, allowed);
}

}  // namespace

std::optional<SheetComparison> compare_with_sheet(const Subject& subject, const ident::Model& model) {
  if (model.input_map && ident::is_one_way(*model.input_map)) return std::nullopt;
  const std::vector<Pair> pairs = pairs_of(subject, model);
  if (pairs.empty()) return std::nullopt;
  SheetComparison result;
  // Numbers that `eha characterise` wrote have the sum; others may be typed, or of a sample.
  const bool is_of_sheet = subject.part("rig", "following", "measured_check").is_number();
  result.seen = fmt::format("Beside {} of the rig file (± is half a 95 % interval):",
                            is_of_sheet ? "the valve sheet in [following]" : "[following]");
  bool first = true;
  bool null_differs = false;
  std::vector<std::string> others;
  std::vector<std::string> changes;
  bool only_gain = true;
  for (const Pair& pair : pairs) {
    result.seen += fmt::format("{} {} {} here and {} there{}, ", first ? "" : ";", pair.name,
                               shown(pair.by_model, pair.unit), shown(pair.by_sheet, pair.unit), pair.in_file);
    result.seen += pair.agrees() ? (pair.apart() <= std::hypot(pair.by_model.half_width, pair.by_sheet.half_width)
                                        ? std::string("they agree")
                                        : fmt::format("they agree within the {:.2g} that the straight lines of the map "
                                                      "allow, not within their intervals",
                                                      pair.allowed()))
                                 : differ_text(pair);
    first = false;
    if (pair.agrees()) continue;
    if (pair.is_null && pair.apart() <= pair.allowed() + kWarmOil_V) {
      null_differs = true;
    } else {
      others.push_back(pair.name);
      const auto [here, there] = told_apart(pair.by_model.value, pair.by_sheet.value);
      changes.push_back(fmt::format("{} {}{}, {} {}", pair.name, here, pair.unit.empty() ? "" : " " + pair.unit,
                                    is_of_sheet ? "on the sheet" : "there", there));
      only_gain = only_gain && pair.name == kGain;
    }
  }
  result.seen += ".";
  if (!others.empty()) {
    result.headline = fmt::format("The rig is not as {} says: {}.",
                                  is_of_sheet ? "the valve sheet in its rig file" : "[following] of its rig file",
                                  fmt::join(changes, "; "));
    result.to_do = fmt::format(
        "{}: {}. {}Measure it again with `eha characterise` before you change anything. ",
        !is_of_sheet ? "Nothing shows that [following] was measured on this rig"
        : only_gain  ? "Valve, pump or load have changed since the sheet"
                     : "The valve has changed since its sheet, or is another one",
        fmt::join(others, ", "),
        only_gain ? "Look at the supply pressure first: the gain follows the square root of what drops over the valve. "
                  : "");
  }
  if (null_differs) {
    result.to_do += fmt::format(
        "{}the model's interval has only the noise of this record. A null moves with the oil's temperature, so measure "
        "it with `eha characterise` before you change anything. ",
        is_of_sheet ? "Trust the valve sheet's null for offset_V and [following]: its interval includes the method's "
                      "error, "
                    : "Of the null ");
  }
  return result;
}

}  // namespace eha::report
