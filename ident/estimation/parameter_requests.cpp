// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/parameter_requests.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/error.hpp"

namespace eha::ident {
namespace {

std::vector<std::string> parameter_names(const StructureOptions& structure) {
  std::vector<std::string> names;
  for (std::size_t i = denominator_terms(structure); i-- > 0;) {
    if (i != 1) names.push_back(coefficient_name(i));
  }
  if (structure.kind == StructureKind::fo) names.insert(names.end(), {"n2", "n1", "b0"});
  if (structure.kind == StructureKind::lag) names.push_back("n1");
  if (structure.kind == StructureKind::commensurate) names.push_back("q");
  for (std::size_t j = 0; j < numerator_terms(structure); ++j) {
    names.push_back(numerator_name(j, numerator_terms(structure)));
  }
  names.insert(names.end(), {"delay_s", "input_bias", "initial_output"});
  return names;
}

}  // namespace

std::string coefficient_name(std::size_t index) { return "a" + std::to_string(index); }
std::string order_name(std::size_t index) { return "n" + std::to_string(index); }

std::string state_name(std::size_t index) { return "x" + std::to_string(index); }
std::string past_input_name(std::size_t index) { return "past_input_" + std::to_string(index); }

bool is_free_response(const std::string& name) { return name.starts_with('x') || name.starts_with("past_input_"); }

std::string numerator_name(std::size_t index, std::size_t terms) {
  return terms == 1 ? "K" : "b" + std::to_string(index);
}

const ParameterRequest* find_request(const StructureOptions& structure, const std::string& name) {
  for (const ParameterRequest& request : structure.parameters) {
    if (request.name == name) return &request;
  }
  return nullptr;
}

bool is_fixed(const StructureOptions& structure, const std::string& name) {
  const ParameterRequest* request = find_request(structure, name);
  return request != nullptr && request->fixed.value_or(false);
}

bool is_freed(const StructureOptions& structure, const std::string& name) {
  const ParameterRequest* request = find_request(structure, name);
  return request != nullptr && !request->fixed.value_or(false) &&
         (request->fixed || request->start || request->lower || request->upper);
}

double requested(const StructureOptions& structure, const std::string& name, double otherwise) {
  const ParameterRequest* request = find_request(structure, name);
  return request != nullptr && request->start ? *request->start : otherwise;
}

std::size_t denominator_terms(const StructureOptions& structure) {
  switch (structure.kind) {
    case StructureKind::fo:
      return 3;
    case StructureKind::lag:
      return 2;
    case StructureKind::io:
    case StructureKind::commensurate:
      break;
  }
  return static_cast<std::size_t>(structure.poles) + 1;
}

std::size_t numerator_terms(const StructureOptions& structure) {
  const bool polynomial = structure.kind == StructureKind::io || structure.kind == StructureKind::commensurate;
  return polynomial ? static_cast<std::size_t>(structure.zeros) + 1 : 1;
}

bool wants_past_input(const StructureOptions& structure) {
  return structure.kind != StructureKind::io && structure.initial_state == InitialState::estimated;
}

void check_requests(const StructureOptions& structure) {
  const std::vector<std::string> known = parameter_names(structure);
  for (const ParameterRequest& request : structure.parameters) {
    if (std::find(known.begin(), known.end(), request.name) == known.end()) {
      throw ConfigError(fmt::format("model {}: parameter {}: expected one of {}, got \"{}\"", structure.name,
                                    request.name, fmt::join(known, ", "), request.name));
    }
    if (request.fixed.value_or(false) && !request.start) {
      throw ConfigError(
          fmt::format("model {}: parameter {}: a fixed parameter needs a value", structure.name, request.name));
    }
  }
  if (structure.poles < 1 || structure.poles > 10 || structure.zeros < 0 || structure.zeros > structure.poles) {
    throw ConfigError(fmt::format("model {}: expected 1 to 10 poles and at most as many zeros, got {} and {}",
                                  structure.name, structure.poles, structure.zeros));
  }
  if (wants_past_input(structure) && numerator_terms(structure) > 1) {
    throw ConfigError(fmt::format(
        "model {}: initial_state: expected auto or none with zeros (a past input is estimated for models without)",
        structure.name));
  }
}

}  // namespace eha::ident
