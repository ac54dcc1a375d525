// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/output_unit.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>

namespace eha::ident {
namespace {

void rescale(Score& score, double factor) {
  score.mse *= factor * factor;
  score.error_min *= factor;
  score.error_max *= factor;
}

bool is_part_of_number(char c) {
  return (c >= '0' && c <= '9') || c == '.' || c == '+' || c == '-' || c == 'e' || c == 'E';
}

/// A sentence with every number that stands before the unit, and the unit, converted: "0.5 in" becomes "12.7 mm".
std::string converted(std::string_view sentence, const std::string& from, const std::string& to, double factor) {
  const std::string behind = " " + from;
  std::string text;
  for (std::size_t at = 0; at < sentence.size();) {
    std::size_t end = at;
    while (end < sentence.size() && is_part_of_number(sentence[end])) ++end;
    if (end == at) {
      text += sentence[at++];
      continue;
    }
    const std::string_view digits = sentence.substr(at, end - at);
    at = end;
    double value = 0.0;
    const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    const bool is_number = error == std::errc() && stop == digits.data() + digits.size();
    const std::string_view rest = sentence.substr(end);
    // The unit, and not the beginning of a longer word.
    const bool has_unit =
        rest.starts_with(behind) && (rest.size() == behind.size() ||
                                     std::string_view(" .,;:)").find(rest[behind.size()]) != std::string_view::npos);
    if (!is_number || !has_unit) {
      text += digits;
      continue;
    }
    text += fmt::format("{:.4g} {}", factor * value, to);
    at += behind.size();
  }
  return text;
}

}  // namespace

bool scales_with_output(ParameterRole role) {
  return role == ParameterRole::numerator_coefficient || role == ParameterRole::initial_output ||
         role == ParameterRole::initial_state;
}

Model in_output_unit(Model model, const std::string& unit, double factor) {
  for (Term& term : model.transfer_function.numerator) term.coefficient *= factor;
  model.initial_output *= factor;
  for (double& state : model.initial_state) state *= factor;
  for (ParameterEstimate& p : model.parameters) {
    if (!scales_with_output(p.role)) continue;
    for (double* value : {&p.value, &p.std, &p.lower95, &p.upper95}) *value *= factor;
  }
  if (model.estimation) {
    rescale(model.estimation->score, factor);
    if (auto& i = model.estimation->information) {
      i->fpe *= factor * factor;
      for (double* criterion : {&i->aic, &i->aicc, &i->bic})
        *criterion += 2.0 * i->effective_samples * std::log(factor);
    }
  }
  if (auto& validation = model.validation) {
    rescale(validation->score, factor);
    if (validation->offset_reestimated) rescale(*validation->offset_reestimated, factor);
    if (validation->tests && validation->tests->drift) {
      validation->tests->drift->change *= factor;
      validation->tests->drift->expected *= factor;
    }
  }
  if (model.bode) {
    for (double& gain : model.bode->gain_dB) gain += 20.0 * std::log10(factor);
  }
  if (model.verdict) {
    for (Criterion& criterion : model.verdict->criteria) {
      if (!criterion.name.ends_with("_max_abs_error") && criterion.name != "residual_drift") continue;
      criterion.value *= factor;
      criterion.limit *= factor;
    }
    for (std::string& reason : model.verdict->reasons) reason = converted(reason, model.output_unit, unit, factor);
  }
  model.output_unit = unit;
  return model;
}

}  // namespace eha::ident
