// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/parameter_change.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha::ident {
namespace {

constexpr double kFewestDegrees = 3.0;
constexpr double kManyDegrees = 1e6;  // for a model without information on its samples

double degrees_of_freedom(const Model& model) {
  if (!model.estimation || !model.estimation->information) return kManyDegrees;
  const InformationCriteria& known = *model.estimation->information;
  const bool is_white = model.estimation->noise && model.estimation->noise->with_parameters;
  const double independent = is_white ? static_cast<double>(known.samples) : known.effective_samples;
  const double degrees = independent - static_cast<double>(known.parameters);
  return std::isfinite(degrees) ? std::max(kFewestDegrees, degrees) : kFewestDegrees;
}

/// Whether a parameter describes the plant rather than a record's start.
bool is_of_plant(ParameterRole role) {
  return role != ParameterRole::initial_output && role != ParameterRole::initial_state &&
         role != ParameterRole::past_input;
}

/// Whether the constant part of the input is that of the level before each record's first row.
bool is_level_before(ParameterRole role, const Model& before, const Model& after) {
  if (role == ParameterRole::input_bias) return comes_to_rest(before) && comes_to_rest(after);
  return role == ParameterRole::valve_null && has_straight_map(before) && has_straight_map(after);
}

struct Compared {
  ParameterEstimate estimate;
  Figure figure = Figure::parameter;
};

bool has_one_pole(const Model& model) {
  const std::vector<Term>& d = model.transfer_function.denominator;
  return d.size() == 2 && has_whole_orders(d) && std::abs(d[0].order + d[1].order - 1.0) < 0.5;
}

bool is_a0(const ParameterEstimate& p) {
  return p.role == ParameterRole::denominator_coefficient && p.name == coefficient_key(0).name;
}

const ParameterEstimate* a0_of(const Model& model) {
  const auto a0 = std::find_if(model.parameters.begin(), model.parameters.end(), is_a0);
  return a0 == model.parameters.end() || !(std::abs(a0->value) > 0.0) ? nullptr : &*a0;
}

/// The numbers of a model to compare. @param at_rest  figure_at_rest() in place of parameters
std::vector<Compared> compared_of(const Model& model, bool at_rest) {
  std::vector<Compared> all;
  for (const ParameterEstimate& p : model.parameters) {
    Compared& one = all.emplace_back(Compared{p});
    const auto instead = at_rest ? figure_at_rest(model, p) : std::nullopt;
    if (!instead) continue;
    one.figure = instead->figure;
    one.estimate.name = instead->name;
    one.estimate.value = instead->value;
    one.estimate.std = instead->std;
    one.estimate.fixed = p.fixed && a0_of(model)->fixed;
  }
  return all;
}

/// Returns the change of the estimate of `name` for a unit change of `cause`, the other parameters adapting: their
/// covariance over the variance of `cause`; 0 if the model does not have them.
double slope_in(const Model& model, const std::string& name, const std::string& cause) {
  if (!model.estimation || !model.estimation->correlation) return 0.0;
  const ParameterCorrelation& known = *model.estimation->correlation;
  const auto index = [&](const std::string& wanted) {
    return static_cast<std::size_t>(std::find(known.names.begin(), known.names.end(), wanted) - known.names.begin());
  };
  const auto std_of = [&](const std::string& wanted) {
    const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [&](const ParameterEstimate& p) { return p.name == wanted; });
    return at == model.parameters.end() ? 0.0 : at->std;
  };
  const std::size_t i = index(name);
  const std::size_t k = index(cause);
  const double cause_std = std_of(cause);
  if (i >= known.matrix.size() || k >= known.matrix.size() || !(cause_std > 0.0)) return 0.0;
  const double slope = known.matrix[i].at(k) * std_of(name) / cause_std;
  return std::isfinite(slope) ? slope : 0.0;
}

/// Returns the shift of a parameter that the change of another makes, by either model's correlations.
double shift_by(const ParameterChange& cause, const ParameterChange& p, const Model& before, const Model& after) {
  const double slope =
      std::max(std::abs(slope_in(before, p.name, cause.name)), std::abs(slope_in(after, p.name, cause.name)));
  return slope * std::abs(cause.after - cause.before);
}

/// Widens the interval of a parameter by the shift that the changes of the map make.
void add_shift_by_map(ParameterChange& p, const PlantChange& change, const Model& before, const Model& after) {
  bool may_lead = std::abs(p.after - p.before) > p.of_noise;
  for (const ParameterChange& cause : change.parameters) {
    if (!is_of_map(cause.role) || !cause.changed) continue;
    const double shift = shift_by(cause, p, before, after);
    p.half_width += shift;
    if (!(shift > p.of_noise)) continue;
    p.follows.push_back(cause.name);
    may_lead = may_lead && std::abs(cause.after - cause.before) <= cause.of_noise + shift_by(p, cause, before, after);
  }
  p.may_lead = may_lead && !p.follows.empty();
}

constexpr double kFarBeyondNoise = 1.5;
constexpr double kMatters = 0.05;       // of the value before
constexpr double kZoneByGain = 0.1;     // of half the dead band, for a gain that changed by all of itself
constexpr double kZoneByPlace = 0.06;   // of half the dead band
constexpr double kRatioByPlace = 0.01;  // of the ratio of the gains

}  // namespace

bool ParameterChange::may_have_changed() const noexcept {
  const double moved = std::abs(after - before);
  return !changed && !follows.empty() && moved > kFarBeyondNoise * of_noise && moved > kMatters * std::abs(before);
}

void widen_to(PlantChange& change, ParameterChange& parameter, double half_width) {
  const bool was_changed = parameter.changed;
  parameter.half_width = std::max(parameter.half_width, half_width);
  parameter.changed = was_changed && std::abs(parameter.after - parameter.before) > parameter.half_width;
  if (!was_changed || parameter.changed) return;
  for (ParameterChange& other : change.parameters) std::erase(other.follows, parameter.name);
}

void widen_beside_other_changes(PlantChange& change, bool is_elsewhere) {
  const auto with = [&](ParameterRole role) {
    return std::find_if(change.parameters.begin(), change.parameters.end(),
                        [&](const ParameterChange& p) { return p.role == role; });
  };
  const auto zone = with(ParameterRole::dead_band);
  if (zone == change.parameters.end()) return;
  const double half_V = std::max(std::abs(zone->before), std::abs(zone->after));
  const auto gain = with(ParameterRole::numerator_coefficient);
  const bool is_other_gain = gain != change.parameters.end() && gain->changed && std::abs(gain->before) > 0.0;
  const double by_gain = is_other_gain ? kZoneByGain * std::abs(gain->after / gain->before - 1.0) : 0.0;
  for (ParameterChange& p : change.parameters) {
    if (!is_of_map(p.role)) continue;
    const bool is_ratio = !is_of_dead_zone(p.role);
    const double by_place = !is_elsewhere ? 0.0 : is_ratio ? kRatioByPlace * std::abs(p.before) : kZoneByPlace * half_V;
    widen_to(change, p, p.half_width + by_place + (is_ratio ? 0.0 : by_gain * half_V));
  }
  change.changed = std::any_of(change.parameters.begin(), change.parameters.end(),
                               [](const ParameterChange& p) { return p.changed; });
}

bool has_gain_at_rest(const Model& model) {
  return !model.input_map && comes_to_rest(model) && model.transfer_function.numerator.size() == 1;
}

std::optional<FigureAtRest> figure_at_rest(const Model& model, const ParameterEstimate& p) {
  const ParameterEstimate* a0 = a0_of(model);
  if (a0 == nullptr) return std::nullopt;
  if (p.role == ParameterRole::numerator_coefficient) {
    const double gain = p.value / a0->value;
    const double variance = p.std * p.std + gain * gain * a0->std * a0->std - 2.0 * gain * covariance(model, p, *a0);
    const bool is_known = !model.output_unit.empty() && !model.input_unit.empty();
    return FigureAtRest{.figure = Figure::gain_at_rest,
                        .name = fmt::format("{}/{}", p.name, a0->name),
                        .value = gain,
                        .std = std::sqrt(std::max(0.0, variance)) / std::abs(a0->value),
                        .unit = is_known ? fmt::format("{}/{}", model.output_unit, model.input_unit) : ""};
  }
  if (!is_a0(p) || !has_one_pole(model)) return std::nullopt;
  return FigureAtRest{.figure = Figure::time_constant,
                      .name = "T",
                      .value = 1.0 / p.value,
                      .std = p.std / (p.value * p.value),
                      .unit = "s"};
}

bool is_of_dead_zone_alone(const PlantChange& change) {
  return std::all_of(change.parameters.begin(), change.parameters.end(),
                     [](const ParameterChange& p) { return !p.changed || is_of_dead_zone(p.role); });
}

bool leaves_plain_noise(const Model& model) {
  return model.estimation && model.estimation->noise && model.estimation->noise->coefficients.empty() &&
         model.estimation->noise->variance > 0.0;
}

PlantChange compare_parameters(const Model& before, const Model& after, double level) {
  PlantChange change;
  const bool at_rest = has_gain_at_rest(before) && has_gain_at_rest(after);
  const std::vector<Compared> others = compared_of(after, at_rest);
  for (const Compared& one : compared_of(before, at_rest)) {
    const ParameterEstimate& p = one.estimate;
    const auto found = std::find_if(others.begin(), others.end(), [&](const Compared& q) {
      return q.estimate.name == p.name && q.figure == one.figure;
    });
    if (found == others.end()) continue;
    const ParameterEstimate* other = &found->estimate;
    if (!is_of_plant(p.role) || (p.fixed && other->fixed)) continue;
    if (is_level_before(p.role, before, after)) continue;
    const double std = std::hypot(p.std, other->std);
    if (!std::isfinite(std)) {
      change.undetermined.push_back(p.name);
      continue;
    }
    change.parameters.push_back(
        {.name = p.name, .role = p.role, .before = p.value, .after = other->value, .std = std, .figure = one.figure});
  }
  if (change.parameters.empty()) return change;
  const double freedom = std::min(degrees_of_freedom(before), degrees_of_freedom(after));
  const double share = level / (2.0 * static_cast<double>(change.parameters.size()));
  const double factor = student_exceeded(share, freedom);
  for (ParameterChange& p : change.parameters) {
    p.half_width = p.of_noise = factor * p.std;
    p.changed = std::abs(p.after - p.before) > p.half_width;
  }
  const bool are_lines = leaves_plain_noise(before) && leaves_plain_noise(after);
  for (ParameterChange& p : change.parameters) {
    if (!is_of_map(p.role) && !are_lines) add_shift_by_map(p, change, before, after);
    p.changed = std::abs(p.after - p.before) > p.half_width;
    change.changed = change.changed || p.changed;
  }
  const auto outside = [](const ParameterChange& p) {
    const double distance = std::abs(p.after - p.before);
    return distance > 0.0 ? distance / std::max(p.half_width, 1e-300) : 0.0;
  };
  std::stable_sort(change.parameters.begin(), change.parameters.end(),
                   [&](const ParameterChange& a, const ParameterChange& b) { return outside(a) > outside(b); });
  return change;
}

PlantChange without_other_units(PlantChange change, const Model& before, const Model& after) {
  if (before.name == after.name) return change;
  const auto has_other = [&](const ParameterChange& p) { return unit_of(p, before) != unit_of(p, after); };
  for (const ParameterChange& p : change.parameters) {
    if (has_other(p)) change.other_unit.push_back(p.name);
  }
  std::erase_if(change.parameters, has_other);
  change.changed = std::any_of(change.parameters.begin(), change.parameters.end(),
                               [](const ParameterChange& p) { return p.changed; });
  return change;
}

std::string lets_follow(const std::vector<std::string>& causes, const std::vector<std::string>& followers) {
  return fmt::format("{} changed, and the fit lets {} follow {}", fmt::join(causes, " and "),
                     fmt::join(followers, " and "), causes.size() == 1 ? "it" : "them");
}

std::string either_follows(const std::vector<std::string>& some, const std::vector<std::string>& others) {
  return fmt::format("{} or {} changed, or both, as the fit lets one follow the other", fmt::join(some, " and "),
                     fmt::join(others, " and "));
}

std::string hidden_sentence(const ParameterChange& change, const Model& model) {
  if (change.changed || change.follows.empty()) return {};
  const std::string name = unit_of(change, model);
  const std::string unit = name.empty() ? "" : " " + name;
  return fmt::format(
      "a change of {} below {:.2g}{} does not show here: {} (by noise alone {:.2g}{}); each fit by itself says {} "
      "before and {} after",
      change.name, change.half_width, unit,
      (change.may_lead ? either_follows : lets_follow)(change.follows, {change.name}), change.of_noise, unit,
      rounded_to(change.before, change.of_noise), rounded_to(change.after, change.of_noise));
}

std::string map_instead(const std::vector<std::string>& changed, bool has_map) {
  if (has_map) return {};
  std::vector<std::string> shown;
  for (const std::string& name : changed) {
    if (name == "K" || name == "input_bias" || name == "b0") shown.push_back(name);
  }
  if (shown.empty()) return {};
  return fmt::format(
      "without a valve map a dead band or null that changed shows as {}: `eha compare` of two such records fits the "
      "map and tells which",
      fmt::join(shown, " and "));
}

std::string unit_instead(const PlantChange& change) {
  struct Factor {
    double ratio;
    std::string_view units;
  };
  constexpr std::array kFactors{Factor{25.4, "in millimetres and the other in inches"},
                                Factor{10.0, "in millimetres and the other in centimetres"},
                                Factor{100.0, "in centimetres and the other in metres"},
                                Factor{1000.0, "in thousandths of the other's (mm and m, mV and V)"}};
  constexpr double kAsNear = 0.01;
  constexpr double kSurely = 0.1;
  for (const ParameterChange& p : change.parameters) {
    if (p.role != ParameterRole::numerator_coefficient || !p.changed || !(p.before * p.after > 0.0)) continue;
    const double ratio = p.after / p.before;
    const double greater = std::max(ratio, 1.0 / ratio);
    const double wide = p.half_width / std::max(std::abs(p.before), std::abs(p.after));
    if (!(wide < kSurely)) continue;
    for (const Factor& factor : kFactors) {
      if (std::abs(greater / factor.ratio - 1.0) > std::max(kAsNear, wide)) continue;
      return fmt::format("{} is {} times as {}: probably no change of the plant, but one record is {}; check the units",
                         p.name, fmt::format("{:.3g}", greater), ratio > 1.0 ? "great" : "small", factor.units);
    }
  }
  return {};
}

std::string value_text(const std::string& parameter, double value, const Model& model, double half_width) {
  const auto found = std::find_if(model.parameters.begin(), model.parameters.end(),
                                  [&](const ParameterEstimate& p) { return p.name == parameter; });
  const bool may_be_0 = found != model.parameters.end() && !found->fixed && is_coefficient(found->role) &&
                        found->lower95 <= 0.0 && found->upper95 > 0.0 && std::isfinite(found->upper95);
  return may_be_0 ? fmt::format("0 to {:.2g}", found->upper95) : rounded_to(value, half_width);
}

std::string value_text(const std::string& parameter, double value, const Model& model) {
  return value_text(parameter, value, model, 0.0);
}

std::string unit_of(const ParameterChange& change, const Model& model) {
  if (change.figure == Figure::time_constant) return "s";
  if (change.figure == Figure::gain_at_rest) {
    const bool is_known = !model.output_unit.empty() && !model.input_unit.empty();
    return is_known ? fmt::format("{}/{}", model.output_unit, model.input_unit) : "";
  }
  return unit_of(ParameterEstimate{.name = change.name, .role = change.role}, model);
}

}  // namespace eha::ident
