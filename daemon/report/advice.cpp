// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/validation/error_cause.hpp"
#include "ident/validation/verdict.hpp"

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

std::string against_error(const Subject& subject, const ident::Model& model) {
  using ident::ErrorCause;
  if (!model.verdict) return {};
  const std::string in_box = "see the note in the box above.";
  switch (ident::error_cause(model, *model.verdict)) {
    case ErrorCause::end_stop:
      return "The output stands at an end, where no model follows it: cut that part as the box above says.";
    case ErrorCause::jump:
      return "The error jumps, which is no part of the plant: cut the record there as the box above says.";
    case ErrorCause::other_plant:
      return "The model is of another plant: fit a new one.";
    case ErrorCause::missing_part:
      return fmt::format("The model {} misses a part of the plant. {}", model.name, what_to_try(subject, model));
    case ErrorCause::nonlinear:
      return "The plant is not linear: " + in_box;
    case ErrorCause::feedback:
      return "The output moves the input: " + in_box;
    case ErrorCause::drift:
      return "What is left wanders: " + in_box;
    case ErrorCause::white_noise:
      return fmt::format("What is left is plain noise of {:.2g} {} rms, in which the input has no part: {}.",
                         std::sqrt(model.validation->score.mse), model.output_unit, ident::kAgainstNoise);
    case ErrorCause::unknown:
      break;
  }
  return {};
}

}  // namespace eha::report
