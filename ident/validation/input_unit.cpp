// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/input_unit.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "ident/structure/parameter_role.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

/// What multiplies a parameter where the input is multiplied by `factor`.
double factor_of(const ParameterKey& key, double factor) {
  switch (key.role) {
    case ParameterRole::numerator_coefficient:
      return 1.0 / factor;
    case ParameterRole::input_bias:
    case ParameterRole::valve_null:
    case ParameterRole::dead_band:
    case ParameterRole::past_input:
      return factor;
    case ParameterRole::grey_box:
      for (const GreyBoxKind* kind : grey_box_kinds()) {
        const std::size_t index = index_of(*kind, key.name);
        if (index >= kind->parameters.size()) continue;
        const GreyBoxUnit unit = kind->parameters[index].unit;
        if (unit == GreyBoxUnit::rate_gain) return 1.0 / factor;
        return unit == GreyBoxUnit::input ? factor : 1.0;
      }
      return 1.0;
    default:
      return 1.0;
  }
}

void rescale_inputs(StructureOptions& asked, double factor) {
  const auto rescale_all = [&](StructureParameter& parameter, double by) {
    for (double* value :
         {&parameter.value, &parameter.lower, &parameter.upper, &parameter.search_lower, &parameter.search_upper}) {
      *value *= by;
    }
  };
  for (StructureTerm& term : asked.structure.numerator) rescale_all(term.coefficient, 1.0 / factor);
  rescale_all(asked.structure.input_map.bias, factor);
  if (auto& valve = asked.structure.input_map.valve) {
    rescale_all(valve->null, factor);
    rescale_all(valve->dead_band, factor);
  }
  for (ParameterRequest& request : asked.parameters) {
    const double by = factor_of(key_of(request.name, asked.structure.numerator.size()), factor);
    for (std::optional<double>* value : {&request.start, &request.lower, &request.upper}) {
      if (*value) **value *= by;
    }
  }
}

}  // namespace

Model in_input_unit(Model model, const std::string& unit, double factor) {
  for (Term& term : model.transfer_function.numerator) term.coefficient /= factor;
  if (model.structure) rescale_inputs(*model.structure, factor);
  if (model.grey_box) {
    for (std::size_t i = 0; i < model.grey_box->values.size(); ++i) {
      const GreyBoxParameter& parameter = model.grey_box->kind->parameters[i];
      model.grey_box->values[i] *= factor_of(grey_box_key(parameter.name, i), factor);
    }
  }
  if (model.input_map) {
    model.input_map->null *= factor;
    model.input_map->dead_band *= factor;
  }
  model.input_bias *= factor;
  for (PastInput& past : model.past_input) past.value *= factor;
  for (ParameterEstimate& p : model.parameters) {
    const double by = factor_of({p.name, p.role, 0}, factor);
    for (double* value : {&p.value, &p.std, &p.lower95, &p.upper95}) *value *= by;
  }
  if (model.estimation && model.estimation->input_range) {
    auto& [lowest, highest] = *model.estimation->input_range;
    std::tie(lowest, highest) = std::minmax(factor * lowest, factor * highest);
  }
  if (auto& validation = model.validation) {
    if (validation->map_error) *validation->map_error *= factor;
    if (auto& noise = validation->input_noise) {
      noise->rms *= factor;
      noise->step *= factor;
    }
    if (auto& levels = validation->input_levels) {
      levels->lower *= factor;
      levels->upper *= factor;
    }
  }
  if (model.bode) {
    for (double& gain : model.bode->gain_dB) gain -= 20.0 * std::log10(factor);
  }
  if (model.verdict) {
    for (Criterion& criterion : model.verdict->criteria) {
      if (criterion.kind != CriterionKind::coefficient_interval) continue;
      const double by = factor_of(key_of(criterion.parameter, model.transfer_function.numerator.size()), factor);
      criterion.value *= by;
      criterion.limit *= by;
    }
  }
  model.input_unit = unit;
  // The stored sentences are in the unit of the file.
  if (model.verdict && !model.verdict->criteria.empty()) model.verdict->reasons = reasons_of(model, *model.verdict);
  return model;
}

}  // namespace eha::ident
