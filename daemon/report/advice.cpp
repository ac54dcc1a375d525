// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "ident/model/parameter_text.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/explanation.hpp"
#include "ident/validation/first_step.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

// The verdict's sentences have reason and remedy; a second remedy beside a plot would contradict them.
constexpr std::string_view kBoxSays = "the box above says what to do.";

}  // namespace

std::string named_in_box(const ident::Model& model) {
  const bool is_named = model.verdict && std::any_of(model.verdict->criteria.begin(), model.verdict->criteria.end(),
                                                     [](const ident::Criterion& c) { return has_failed(c); });
  return is_named ? std::string(kBoxSays) : std::string();
}

std::string nothing_to_do(const Subject& subject) {
  return subject.next_step().first == ident::FirstStep::none ? "Nothing."
                                                             : "Nothing here; what comes first the box above says.";
}

std::string against_error(const ident::Model& model) {
  using ident::ErrorCause;
  if (!model.verdict) return {};
  const std::string in_box(kBoxSays);
  if (const auto explanation = ident::explanation_of(model, *model.verdict)) {
    switch (explanation->kind) {
      case ident::ExplanationKind::structure:
        return "Another structure describes what is left: " + in_box;
      case ident::ExplanationKind::limit:
        return "The plant saturates: " + in_box;
      case ident::ExplanationKind::power:
        return "The plant's gain is curved: " + in_box;
      case ident::ExplanationKind::play:
        return "The plant has a play: " + in_box;
    }
  }
  switch (ident::error_cause(model, *model.verdict)) {
    case ErrorCause::wrong_input:
      return "The input column is wrong: " + in_box;
    case ErrorCause::moved_rows:
      return "The rows were moved in time: " + in_box;
    case ErrorCause::frozen:
      return "The sensor froze, which no model follows: cut that part as the box above says.";
    case ErrorCause::slow_rows:
      return "The rows are too slow for the plant: " + in_box;
    case ErrorCause::end_stop:
      return "The output stands at an end, where no model follows it: cut that part as the box above says.";
    case ErrorCause::jump:
      return "The error jumps, which is no part of the plant: cut the record there as the box above says.";
    case ErrorCause::other_plant:
      return "The model is of another plant: fit a new one.";
    case ErrorCause::input_noise:
      return "The recorded input is noisy or coarse: " + in_box;
    case ErrorCause::missing_part:
      if (ident::is_rather_nonlinear(model, *model.verdict)) return "The plant is not linear: " + in_box;
      return fmt::format("The model {} misses a part of the plant: {}", model.name, kBoxSays);
    case ErrorCause::nonlinear:
      return "The plant is not linear: " + in_box;
    case ErrorCause::feedback:
      return "The output moves the input: " + in_box;
    case ErrorCause::drift:
      return "What is left wanders: " + in_box;
    case ErrorCause::white_noise:
      return fmt::format("What is left is plain noise of {} rms, in which the input has no part: {}.",
                         ident::error_text(std::sqrt(model.validation->score.mse), model.output_unit),
                         ident::kAgainstNoise);
    case ErrorCause::unknown:
      break;
  }
  return {};
}

}  // namespace eha::report
