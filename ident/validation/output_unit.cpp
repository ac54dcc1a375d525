// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/output_unit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

void rescale(Score& score, double factor) {
  score.mse *= factor * factor;
  score.error_min *= factor;
  score.error_max *= factor;
}

bool is_coefficient_of_output(const Model& model, const std::string& parameter) {
  const ParameterKey key = key_of(parameter, model.transfer_function.numerator.size());
  return key.role != ParameterRole::initial_state && scales_with_output(key);
}

void rescale(StructureOptions& asked, double factor) {
  const auto rescale_all = [&](StructureParameter& parameter) {
    for (double* value :
         {&parameter.value, &parameter.lower, &parameter.upper, &parameter.search_lower, &parameter.search_upper}) {
      *value *= factor;
    }
  };
  for (StructureTerm& term : asked.structure.numerator) rescale_all(term.coefficient);
  rescale_all(asked.structure.initial_output);
  for (ParameterRequest& request : asked.parameters) {
    if (!scales_with_output(key_of(request.name, asked.structure.numerator.size()))) continue;
    for (std::optional<double>* value : {&request.start, &request.lower, &request.upper}) {
      if (*value) **value *= factor;
    }
  }
}

}  // namespace

bool scales_with_output(const ParameterKey& key) {
  const ParameterRole role = key.role;
  if (role == ParameterRole::grey_box) {
    for (const GreyBoxKind* kind : grey_box_kinds()) {
      const std::size_t index = index_of(*kind, key.name);
      if (index >= kind->parameters.size()) continue;
      const GreyBoxUnit unit = kind->parameters[index].unit;
      return unit == GreyBoxUnit::output || unit == GreyBoxUnit::rate_gain;
    }
  }
  return role == ParameterRole::numerator_coefficient || role == ParameterRole::initial_output ||
         role == ParameterRole::initial_state;
}

Model in_output_unit(Model model, const std::string& unit, double factor) {
  for (Term& term : model.transfer_function.numerator) term.coefficient *= factor;
  if (model.structure) rescale(*model.structure, factor);
  if (model.grey_box) {
    for (std::size_t i = 0; i < model.grey_box->values.size(); ++i) {
      const GreyBoxParameter& parameter = model.grey_box->kind->parameters[i];
      if (scales_with_output(grey_box_key(parameter.name, i))) model.grey_box->values[i] *= factor;
    }
  }
  model.initial_output *= factor;
  for (double& state : model.initial_state) state *= factor;
  for (ParameterEstimate& p : model.parameters) {
    if (!scales_with_output({p.name, p.role, 0})) continue;
    for (double* value : {&p.value, &p.std, &p.lower95, &p.upper95}) *value *= factor;
  }
  if (model.estimation) {
    rescale(model.estimation->score, factor);
    if (auto& noise = model.estimation->noise) {
      noise->power *= factor * factor;
      noise->variance *= factor * factor;
    }
    if (auto& i = model.estimation->information) {
      i->fpe *= factor * factor;
      for (double* criterion : {&i->aic, &i->aicc, &i->bic})
        *criterion += 2.0 * i->effective_samples * std::log(factor);
    }
  }
  if (auto& validation = model.validation) {
    rescale(validation->score, factor);
    if (validation->offset_reestimated) rescale(*validation->offset_reestimated, factor);
    if (auto& stop = validation->end_stop) {
      stop->level *= factor;
      if (stop->other) stop->other->level *= factor;
    }
    if (validation->sensor_step) validation->sensor_step->step *= factor;
    if (validation->between_rows) *validation->between_rows *= factor;
    if (validation->input_noise) validation->input_noise->in_output *= factor;
    if (validation->jump) {
      validation->jump->change *= factor;
      validation->jump->usual *= factor;
    }
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
      const bool is_of_output = criterion.kind == CriterionKind::coefficient_interval
                                    ? is_coefficient_of_output(model, criterion.parameter)
                                    : traits_of(criterion.kind).unit == CriterionUnit::output;
      if (!is_of_output) continue;
      criterion.value *= factor;
      criterion.limit *= factor;
    }
  }
  model.output_unit = unit;
  // The stored sentences are in the unit of the file.
  if (model.verdict && !model.verdict->criteria.empty()) model.verdict->reasons = reasons_of(model, *model.verdict);
  return model;
}

PlantChange in_output_unit(PlantChange change, double factor) {
  for (ParameterChange& p : change.parameters) {
    if (!scales_with_output({p.name, p.role, 0})) continue;
    for (double* value : {&p.before, &p.after, &p.std, &p.half_width, &p.of_noise}) *value *= factor;
  }
  return change;
}

Model in_unit(Model model, const DisplayUnit& unit) {
  const std::string shown = unit.of(model.output_unit);
  if (shown == model.output_unit) return model;
  const double factor = unit.factor(model.output_unit);
  return in_output_unit(std::move(model), shown, factor);
}

std::string requoted(std::string text, const Model& before, const Model& after) {
  if (!before.verdict || !after.verdict) return text;
  const std::vector<std::string>& reasons = before.verdict->reasons;
  const std::vector<std::string>& shown = after.verdict->reasons;
  for (std::size_t i = 0; i < std::min(reasons.size(), shown.size()); ++i) {
    const auto without_point = [](std::string sentence) {
      if (sentence.ends_with('.')) sentence.pop_back();
      return sentence;
    };
    // Earlier versions quoted whole sentences.
    const std::string whole = without_point(reasons[i]);
    const bool is_whole = !whole.empty() && text.find(whole) != std::string::npos;
    const std::string quoted = is_whole ? whole : statement_of(reasons[i]);
    if (quoted.empty()) continue;
    const std::string instead = is_whole ? without_point(shown[i]) : statement_of(shown[i]);
    for (std::size_t at = text.find(quoted); at != std::string::npos; at = text.find(quoted, at + instead.size())) {
      text.replace(at, quoted.size(), instead);
    }
  }
  return text;
}

}  // namespace eha::ident
