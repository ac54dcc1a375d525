// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "config/measured_check.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "hal/backends/backend.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha {
namespace {

constexpr double kWorstScaleShare = 0.1;
constexpr double kLeastSpread_V = 0.1;
constexpr double kLeastSpread_in = 0.1;
constexpr double kAnotherSensor = 1.5;   // ratio of scales beyond which what was measured must be measured anew
constexpr double kDistinctShare = 0.05;  // of the spread: least difference of two positions

/// Returns the byte offset of a position in a text.
std::size_t offset_of(const std::string& text, const config::Position& position) {
  std::size_t at = 0;
  for (std::uint32_t line = 1; line < position.line; ++line) at = text.find('\n', at) + 1;
  for (std::uint32_t column = 1; column < position.column; ++at) {
    // Bytes that continue a character of UTF-8 do not count.
    if (at + 1 >= text.size() || (static_cast<unsigned char>(text[at + 1]) & 0xC0U) != 0x80U) ++column;
  }
  return at;
}

/// Returns the end of a TOML number or basic string that begins at `at`.
std::size_t end_of_value(const std::string& text, std::size_t at) {
  if (text[at] == '"' || text[at] == '\'') return text.find(text[at], at + 1) + 1;
  return std::min(text.find_first_of(" \t\r\n#,}", at), text.size());
}

/// Returns the offset of the line after the head of a table; adds a missing head at the end of the text.
std::size_t line_below_head(std::string& text, const std::string& table) {
  const std::string head = "[" + table + "]";
  std::size_t at = text.find("\n" + head);
  if (at == std::string::npos) {
    text += "\n" + head + "\n";
    return text.size();
  }
  at = text.find('\n', at + 1);
  if (at == std::string::npos) {
    text += '\n';
    return text.size();
  }
  return at + 1;
}

/// A key of a table and its new value, as TOML.
struct NewValue {
  std::string key;
  std::string value;
  std::string old_key = {};  ///< key of the file that it replaces; empty: the same one
};

/// Returns the values under the keys that the file has. Lengths are in millimetres if the file's key is, or if the
/// file's units are millimetres.
std::vector<NewValue> as_written(const config::RigConfig& rig, const std::string& table, std::vector<NewValue> values) {
  for (NewValue& value : values) {
    const auto written = millimetre_key(value.key);
    if (!written) continue;
    const bool stands_so = rig.positions.contains(table + "." + written->name);
    if (!stands_so && rig.units != "mm") continue;
    const std::string old_key = stands_so ? std::string() : value.key;
    value = {written->name, fmt::format("{:.6g}", std::strtod(value.value.c_str(), nullptr) / written->factor),
             old_key};
  }
  return values;
}

/// Replaces a value, and its key if that has another unit; then also "[in/V]" in the comment of its line.
void replace(std::string& text, std::size_t at, const NewValue& value) {
  const std::size_t end = end_of_value(text, at);
  if (!value.old_key.empty()) {
    const std::size_t line_end = std::min(text.find('\n', at), text.size());
    for (const char* unit : {"[in/", "[in]"}) {
      const std::size_t found = text.find(unit, end);
      if (found < line_end) text.replace(found + 1, 2, "mm");
    }
  }
  text.replace(at, end - at, value.value);
  const std::size_t key = value.old_key.empty() ? text.npos : text.rfind(value.old_key, at);
  if (key != text.npos) text.replace(key, value.old_key.size(), value.key);
}

std::string with_values(const config::RigConfig& rig, const std::string& table, const std::vector<NewValue>& given) {
  const std::vector<NewValue> values = as_written(rig, table, given);
  std::string text = rig.text;
  std::map<std::size_t, const NewValue*, std::greater<>> at;  // from the end, so that offsets stay valid
  std::string added;
  for (const NewValue& value : values) {
    const auto found = rig.positions.find(table + "." + (value.old_key.empty() ? value.key : value.old_key));
    if (found == rig.positions.end()) {
      added += fmt::format("{} = {}\n", value.key, value.value);
    } else {
      at[offset_of(text, found->second)] = &value;
    }
  }
  for (const auto& [offset, value] : at) replace(text, offset, *value);
  if (!added.empty()) text.insert(line_below_head(text, table), added);
  return text;
}

}  // namespace

Calibration calibrated(std::span<const CalibrationPoint> points, const DisplayUnit& unit) {
  const std::string in = unit.of("in");
  const double factor = unit.factor("in");
  if (points.size() < kFewestCalibrationPoints) {
    throw DataError(fmt::format("{} position{}, at least {} are needed; measure some more, spread over the travel",
                                points.size(), points.size() == 1 ? "" : "s", kFewestCalibrationPoints));
  }
  const auto count = static_cast<double>(points.size());
  double mean_V = 0.0;
  double mean_in = 0.0;
  for (const CalibrationPoint& point : points) {
    if (!std::isfinite(point.position_in) || !std::isfinite(point.voltage_V)) {
      throw DataError("a position or a voltage is not a finite number; leave it out");
    }
    mean_V += point.voltage_V / count;
    mean_in += point.position_in / count;
  }
  double vv = 0.0;
  double vy = 0.0;
  double lowest_V = points.front().voltage_V;
  double highest_V = lowest_V;
  double lowest_in = points.front().position_in;
  double highest_in = lowest_in;
  for (const CalibrationPoint& point : points) {
    vv += (point.voltage_V - mean_V) * (point.voltage_V - mean_V);
    vy += (point.voltage_V - mean_V) * (point.position_in - mean_in);
    lowest_V = std::min(lowest_V, point.voltage_V);
    highest_V = std::max(highest_V, point.voltage_V);
    lowest_in = std::min(lowest_in, point.position_in);
    highest_in = std::max(highest_in, point.position_in);
  }
  if (highest_V - lowest_V < kLeastSpread_V || highest_in - lowest_in < kLeastSpread_in) {
    throw DataError(fmt::format(
        "the voltages spread over {:.3g} V and the positions over {:.3g} {}; {:g} V and {:.3g} {} at least are needed: "
        "move the rod farther between the positions",
        highest_V - lowest_V, factor * (highest_in - lowest_in), in, kLeastSpread_V, factor * kLeastSpread_in, in));
  }
  std::vector<double> distinct;
  for (const CalibrationPoint& point : points) {
    const bool is_new = std::all_of(distinct.begin(), distinct.end(), [&](double other) {
      return std::abs(other - point.position_in) > kDistinctShare * (highest_in - lowest_in);
    });
    if (is_new) distinct.push_back(point.position_in);
  }
  if (distinct.size() < kFewestCalibrationPoints) {
    throw DataError(fmt::format("{} places that differ; expected at least {}, one in the middle", distinct.size(),
                                kFewestCalibrationPoints));
  }
  Calibration found{.scale_in_per_V = vy / vv, .voltage_squares_V2 = vv, .mean_V = mean_V};
  found.offset_in = mean_in - found.scale_in_per_V * mean_V;
  double squares = 0.0;
  for (const CalibrationPoint& point : points) {
    found.residuals_in.push_back(point.position_in - found.offset_in - found.scale_in_per_V * point.voltage_V);
    squares += found.residuals_in.back() * found.residuals_in.back();
  }
  found.residual_std = std::sqrt(squares / (count - 2.0));
  found.scale_std = found.residual_std / std::sqrt(vv);
  found.offset_std = found.residual_std * std::sqrt(1.0 / count + mean_V * mean_V / vv);
  found.interval_factor = ident::student_exceeded(0.025, count - 2.0);
  if (!(found.scale_std < kWorstScaleShare * std::abs(found.scale_in_per_V))) {
    throw DataError(fmt::format(
        "the positions lie on no line: scale {:.4g} +- {:.2g} {}/V, residuals up to {:.3g} {}; check each position and "
        "the unit, and that the sensor's wire moves with the rod",
        factor * found.scale_in_per_V, factor * found.interval_factor * found.scale_std, in,
        factor * std::abs(*std::max_element(found.residuals_in.begin(), found.residuals_in.end(),
                                            [](double a, double b) { return std::abs(a) < std::abs(b); })),
        in));
  }
  return found;
}

std::optional<LonePoint> lone_point(std::span<const CalibrationPoint> points, double tolerance_in) {
  if (points.size() < kFewestCalibrationPoints + 2) return std::nullopt;
  std::optional<LonePoint> lone;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::vector<CalibrationPoint> others(points.begin(), points.end());
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    try {
      const Calibration found = calibrated(others);
      double others_in = 0.0;
      for (const double residual_in : found.residuals_in) others_in = std::max(others_in, std::abs(residual_in));
      if (others_in > tolerance_in) continue;
      if (lone) return std::nullopt;
      lone = {i, points[i].position_in - found.offset_in - found.scale_in_per_V * points[i].voltage_V, others_in};
    } catch (const DataError&) {
      continue;  // the others alone are no calibration
    }
  }
  return lone;
}

double rounding_in(const Calibration& found, double range_V) {
  constexpr double kCodes = 65535.0;
  return std::abs(found.scale_in_per_V) * range_V / kCodes / std::sqrt(12.0);
}

std::string doubt_about(std::span<const CalibrationPoint> points, const Calibration& found, const DisplayUnit& unit) {
  constexpr double kGoodShare = 0.05;
  const double share = found.interval_factor * found.scale_std / std::abs(found.scale_in_per_V);
  if (share <= kGoodShare) return {};
  // How far a reading is off the line through the others; of three each is off that of the other two.
  const bool is_told = points.size() > kFewestCalibrationPoints;
  std::size_t worst = 0;
  double worst_in = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double away_V = points[i].voltage_V - found.mean_V;
    const double pull =
        is_told ? 1.0 / static_cast<double>(points.size()) + away_V * away_V / found.voltage_squares_V2 : 0.0;
    const double off_in = std::abs(found.residuals_in[i]) / std::max(1e-6, 1.0 - pull);
    if (off_in <= worst_in) continue;
    worst = i;
    worst_in = off_in;
  }
  const double factor = unit.factor("in");
  return fmt::format(
      "the scale is known to +- {:.2g} % only, {:g} % would do; {} {:.4g} {}: measure it again, or add readings{}",
      100.0 * share, 100.0 * kGoodShare,
      is_told ? "off the line of the others most is the one at" : "farthest off is the one at",
      factor * points[worst].position_in, unit.of("in"),
      is_told ? "" : "; of three readings each of the other two may be the wrong one, a fourth one shows which");
}

PlaceShift greatest_shift(const config::RigLimits& limits, const hal::Conversion& before,
                          const hal::Conversion& after) {
  PlaceShift greatest;
  for (const double place_in : {limits.travel_min_in, limits.travel_max_in}) {
    const double voltage_V = (place_in - before.offset_in) / before.scale_in_per_V;
    const double by_in = after.offset_in + after.scale_in_per_V * voltage_V - place_in;
    if (std::abs(by_in) > std::abs(greatest.by_in) + 1e-6) greatest = {place_in, by_in};
  }
  return greatest;
}

PlaceShift greatest_shift(const config::RigConfig& rig, const Calibration& calibration) {
  const hal::Conversion before = hal::conversion_of(rig.backend);
  hal::Conversion after = before;
  after.scale_in_per_V = calibration.scale_in_per_V;
  after.offset_in = calibration.offset_in;
  return greatest_shift(rig.limits, before, after);
}

std::string shift_text(const config::RigConfig& rig, const Calibration& calibration, const DisplayUnit& unit) {
  constexpr double kSame_in = 0.1;
  const PlaceShift shift = greatest_shift(rig, calibration);
  if (!(std::abs(shift.by_in) > kSame_in)) return {};
  const double factor = unit.factor("in");
  return fmt::format(
      "by the new calibration the rod stands at {0:.4g} {2} where {3} has {1:.4g} {2}. Unless the sensor was exchanged "
      "or moved, or that file was never calibrated, the ruler was read wrong: from another zero, or in another unit. "
      "The travel limits move with it, and the rod would meet an end stop at full speed: hold the ruler to the rod at "
      "one more place, and see that `eha read` agrees, before anything moves",
      factor * (shift.at_in + shift.by_in), factor * shift.at_in, unit.of("in"), rig.file_name);
}

std::string calibrated_rig_text(const config::RigConfig& rig, const Calibration& calibration, const std::string& date) {
  const std::string table(hal::name_of(rig.backend));
  std::vector<NewValue> values{{"scale_in_per_V", fmt::format("{:.6g}", calibration.scale_in_per_V)},
                               {"offset_in", fmt::format("{:.6g}", calibration.offset_in)}};
  if (!hal::conversion_of(rig.backend).calibration_date.empty()) {
    values.push_back({"calibration_date", "\"" + date + "\""});
  }
  const config::RigConfig changed = config::parse_rig(with_values(rig, table, values), rig.file_name);
  if (!config::is_as_measured(rig)) return changed.text;
  // The same volts move the same rod: what was measured is as many inches more or less as the scale makes them.
  config::Following following = *rig.limits.following;
  const double factor =
      std::abs(hal::conversion_of(changed.backend).scale_in_per_V / hal::conversion_of(rig.backend).scale_in_per_V);
  following.gain_positive_in_per_V_s *= factor;
  following.gain_negative_in_per_V_s *= factor;
  // Another sensor, a scale that was wrong all along, or positions in a wrong unit: the gains follow, but nobody has
  // measured by this scale. The sums stay and do not fit, so that arming refuses these lines: without sums they would
  // pass as numbers by hand, while a characterisation without [following] compares the sensor with a ruler first.
  if (std::max(factor, 1.0 / factor) > kAnotherSensor) {
    return with_values(changed, "following",
                       {{"gain_positive_in_per_V_s", fmt::format("{:.4g}", following.gain_positive_in_per_V_s)},
                        {"gain_negative_in_per_V_s", fmt::format("{:.4g}", following.gain_negative_in_per_V_s)}});
  }
  following.measured_rig_check = config::measured_rig_check_of(changed.backend);
  return rig_text_with(changed, following);
}

std::string rig_text_with(const config::RigConfig& rig, const config::Following& following) {
  std::vector<NewValue> values{{"gain_positive_in_per_V_s", fmt::format("{:.4g}", following.gain_positive_in_per_V_s)},
                               {"gain_negative_in_per_V_s", fmt::format("{:.4g}", following.gain_negative_in_per_V_s)},
                               {"null_V", fmt::format("{:.4f}", following.null_V)},
                               {"dead_band_V", fmt::format("{:.4f}", following.dead_band_V)}};
  const auto add = [&](const char* key, const std::optional<double>& value) {
    if (value) values.push_back({key, fmt::format("{:.4f}", *value)});
  };
  add("null_uncertainty_V", following.null_uncertainty_V);
  add("dead_band_uncertainty_V", following.dead_band_uncertainty_V);
  add("gain_uncertainty_percent", following.gain_uncertainty_percent);
  const config::RigConfig written = config::parse_rig(with_values(rig, "following", values), rig.file_name);
  const config::Following& read = *written.limits.following;
  // Only what has its uncertainties was measured by eha characterise.
  if (!following.dead_band_uncertainty_V) return written.text;
  std::vector<NewValue> sums{{"measured_check", fmt::format("{}", config::measured_check_of(read))}};
  if (following.measured_rig_check) {
    sums.push_back({"measured_rig_check", fmt::format("{}", *following.measured_rig_check)});
  }
  return with_values(written, "following", sums);
}

std::string rig_text_without_following(const config::RigConfig& rig) {
  std::string text;
  bool is_inside = false;
  for (std::size_t at = 0; at < rig.text.size();) {
    const std::size_t end = std::min(rig.text.find('\n', at), rig.text.size() - 1) + 1;
    const std::string line = rig.text.substr(at, end - at);
    const std::size_t first = line.find_first_not_of(" \t\r\n");
    if (first != std::string::npos && line[first] == '[') {
      std::string head = line.substr(first, line.find(']', first) - first + 1);
      std::erase_if(head, [](char c) { return c == ' ' || c == '\t'; });
      is_inside = head == "[following]";
    }
    const bool is_key = is_inside && first != std::string::npos && line[first] != '#';
    text += (is_key ? "# " : "") + line;
    at = end;
  }
  if (config::parse_rig(text, rig.file_name).limits.following) {
    throw ConfigError(
        fmt::format("{}: [following] is not written as a table of its own; comment it out by hand", rig.file_name));
  }
  return text;
}

std::string rig_text_with_tick(const config::RigConfig& rig, double sample_period_s) {
  std::string text = with_values(rig, "realtime", {{"sample_period_s", fmt::format("{:#}", sample_period_s)}});
  static_cast<void>(config::parse_rig(text, rig.file_name));
  return text;
}

}  // namespace eha
