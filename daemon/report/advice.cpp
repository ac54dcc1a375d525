// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

namespace eha::report {
namespace {

template <class Has>
bool any_model(const Subject& subject, const Has& has) {
  return std::any_of(subject.models.begin(), subject.models.end(),
                     [&](const ReportedModel& reported) { return has(reported.model); });
}

}  // namespace

bool has_valve_map(const Subject& subject) {
  return any_model(subject, [](const ident::Model& model) { return model.input_map.has_value(); });
}

std::string what_to_try(const Subject& subject, const ident::Model& model) {
  std::vector<std::string> untried;
  if (!has_valve_map(subject)) untried.emplace_back("--input-map valve");
  const double own = highest_order(model.transfer_function.denominator);
  if (!any_model(subject,
                 [&](const ident::Model& other) { return highest_order(other.transfer_function.denominator) > own; })) {
    untried.emplace_back("more poles");
  }
  if (!any_model(subject, [](const ident::Model& other) { return other.transfer_function.delay_s > 0.0; })) {
    untried.emplace_back("--delay free");
  }
  if (untried.empty()) {
    return "A valve's map, more poles and a delay are among the models already: record smaller motions, in which the "
           "plant is nearer to linear, or use the model with this in mind.";
  }
  return fmt::format("Try {}.", fmt::join(untried, " or "));
}

}  // namespace eha::report
