// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/parameter_change.hpp"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace eha::ident {
namespace {

constexpr double kFewestDegrees = 3.0;
constexpr double kManyDegrees = 1e6;  // of a model that tells nothing of its samples

double degrees_of_freedom(const Model& model) {
  if (!model.estimation || !model.estimation->information) return kManyDegrees;
  const InformationCriteria& known = *model.estimation->information;
  const double degrees = known.effective_samples - static_cast<double>(known.parameters);
  return std::isfinite(degrees) ? std::max(kFewestDegrees, degrees) : kFewestDegrees;
}

/// Whether a parameter says something of the plant rather than of a record's start.
bool is_of_plant(ParameterRole role) {
  return role != ParameterRole::initial_output && role != ParameterRole::initial_state &&
         role != ParameterRole::past_input;
}

}  // namespace

PlantChange compare_parameters(const Model& before, const Model& after, double level) {
  PlantChange change;
  for (const ParameterEstimate& p : before.parameters) {
    const auto other = std::find_if(after.parameters.begin(), after.parameters.end(),
                                    [&](const ParameterEstimate& q) { return q.name == p.name; });
    if (other == after.parameters.end() || !is_of_plant(p.role) || (p.fixed && other->fixed)) continue;
    const double std = std::hypot(p.std, other->std);
    if (!std::isfinite(std)) {
      change.undetermined.push_back(p.name);
      continue;
    }
    change.parameters.push_back({p.name, p.role, p.value, other->value, std, 0.0, false});
  }
  if (change.parameters.empty()) return change;
  const boost::math::students_t student(std::min(degrees_of_freedom(before), degrees_of_freedom(after)));
  const double share = level / (2.0 * static_cast<double>(change.parameters.size()));
  const double factor = boost::math::quantile(boost::math::complement(student, share));
  for (ParameterChange& p : change.parameters) {
    p.half_width = factor * p.std;
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

std::string unit_of(ParameterRole role, const Model& model) {
  switch (role) {
    case ParameterRole::input_bias:
    case ParameterRole::valve_null:
    case ParameterRole::dead_band:
      return model.input_unit;
    case ParameterRole::delay:
      return "s";
    default:
      return "";
  }
}

}  // namespace eha::ident
