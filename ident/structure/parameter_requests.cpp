// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/structure/parameter_requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"

namespace eha::ident {

const ParameterRequest* find_request(const StructureOptions& asked, const StructureParameter& parameter) {
  for (const ParameterRequest& request : asked.parameters) {
    if (request.name == parameter.key.name) return &request;
  }
  return nullptr;
}

bool is_estimated(const StructureOptions& asked, const StructureParameter& parameter) {
  const ParameterRequest* request = find_request(asked, parameter);
  const bool held = request != nullptr && request->fixed.value_or(false);
  switch (parameter.freedom) {
    case Freedom::constant:
      return false;
    case Freedom::free:
      return !held;
    case Freedom::held:
      break;
  }
  // Any request except a value to hold the parameter at frees it.
  return request != nullptr && !held && (request->fixed || request->start || request->lower || request->upper);
}

double requested(const StructureOptions& asked, const StructureParameter& parameter) {
  const ParameterRequest* request = find_request(asked, parameter);
  const bool has_value = request != nullptr && request->start && parameter.freedom != Freedom::constant;
  return has_value ? *request->start : parameter.value;
}

bool declares_integrator(const StructureOptions& asked) {
  const StructureTerm& lowest = asked.structure.denominator.front();
  const auto held = [&](const StructureParameter& parameter) { return !is_estimated(asked, parameter); };
  if (held(lowest.coefficient) && std::abs(requested(asked, lowest.coefficient)) <= 0.0) return true;
  return !asked.structure.base_order && held(lowest.order) && requested(asked, lowest.order) > 0.0;
}

bool wants_past_input(const StructureOptions& asked) {
  return asked.initial_state == InitialState::estimated && !has_finite_state(asked.structure);
}

bool ratio_enters_linearly(const StructureOptions& asked) {
  const auto& valve = asked.structure.input_map.valve;
  if (!valve || !is_estimated(asked, valve->negative_gain_ratio)) return false;
  const ParameterRequest* request = find_request(asked, valve->negative_gain_ratio);
  const bool bounded = request != nullptr && (request->lower || request->upper);
  return !bounded && asked.structure.numerator.size() == 1;
}

void check_requests(const StructureOptions& asked) {
  std::vector<std::string> known;
  for (const StructureParameter* parameter : requestable_parameters(asked.structure)) {
    known.push_back(parameter->key.name);
  }
  for (const ParameterRequest& request : asked.parameters) {
    if (std::find(known.begin(), known.end(), request.name) == known.end()) {
      throw ConfigError(fmt::format("model {}: parameter {}: expected one of {}, got \"{}\"", asked.name, request.name,
                                    fmt::join(known, ", "), request.name));
    }
    if (request.fixed.value_or(false) && !request.start) {
      throw ConfigError(
          fmt::format("model {}: parameter {}: a fixed parameter needs a value", asked.name, request.name));
    }
  }
  if (wants_past_input(asked) && asked.structure.numerator.size() > 1) {
    throw ConfigError(fmt::format(
        "model {}: initial_state: expected auto or none with zeros (a past input is estimated for models without)",
        asked.name));
  }
}

}  // namespace eha::ident
