// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/structure_node.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace eha::ident {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Node = ModelNode;

constexpr std::size_t kMostTerms = 24;
constexpr int kMostDegrees = 20;

constexpr auto kFreedoms = std::to_array<std::pair<std::string_view, Freedom>>(
    {{"constant", Freedom::constant}, {"held", Freedom::held}, {"free", Freedom::free}});
constexpr auto kInitialStates = std::to_array<std::pair<std::string_view, InitialState>>(
    {{"auto", InitialState::automatic}, {"none", InitialState::none}, {"estimated", InitialState::estimated}});

template <typename Names, typename Value>
std::string_view name_in(const Names& names, Value value) {
  for (const auto& [name, known] : names) {
    if (known == value) return name;
  }
  return names.front().first;
}

template <typename Names, typename Value>
void read_name(const Node& node, const Names& names, Value& target) {
  std::string text;
  node.read(text);
  std::string all;
  for (const auto& [name, known] : names) {
    if (name == text) {
      target = known;
      return;
    }
    all += fmt::format("{}\"{}\"", all.empty() ? "" : ", ", name);
  }
  node.refuse("one of " + all);
}

/// A bound and its key in the file.
struct Bound {
  const char* key;
  double StructureParameter::*value;
};
constexpr std::array kBounds{Bound{"lower", &StructureParameter::lower}, Bound{"upper", &StructureParameter::upper},
                             Bound{"search_lower", &StructureParameter::search_lower},
                             Bound{"search_upper", &StructureParameter::search_upper}};

OrderedJson to_json(const StructureParameter& parameter) {
  OrderedJson object{{"value", parameter.value}, {"freedom", name_in(kFreedoms, parameter.freedom)}};
  for (const Bound& bound : kBounds) {
    if (std::isfinite(parameter.*bound.value)) object[bound.key] = parameter.*bound.value;
  }
  if (!parameter.listed) object["listed"] = false;
  return object;
}

OrderedJson to_json(const std::vector<StructureTerm>& terms) {
  OrderedJson list = OrderedJson::array();
  for (const StructureTerm& term : terms) {
    list.push_back({{"coefficient", to_json(term.coefficient)}, {"order", to_json(term.order)}});
  }
  return list;
}

OrderedJson to_json(const InputMap& map) {
  OrderedJson object{{"bias", to_json(map.bias)}};
  if (!map.valve) return object;
  object["null"] = to_json(map.valve->null);
  object["dead_band"] = to_json(map.valve->dead_band);
  object["negative_gain_ratio"] = to_json(map.valve->negative_gain_ratio);
  return object;
}

OrderedJson to_json(const ParameterRequest& request) {
  OrderedJson object{{"name", request.name}};
  if (request.fixed) object["fixed"] = *request.fixed;
  if (request.start) object["start"] = *request.start;
  if (request.lower) object["lower"] = *request.lower;
  if (request.upper) object["upper"] = *request.upper;
  return object;
}

StructureParameter read_parameter(const Node& node, ParameterKey key) {
  const Node object = node.object({"value", "freedom", "lower", "upper", "search_lower", "search_upper", "listed"});
  StructureParameter parameter{.key = std::move(key), .value = object.at("value").number()};
  read_name(object.at("freedom"), kFreedoms, parameter.freedom);
  for (const Bound& bound : kBounds) {
    if (object.has(bound.key)) parameter.*bound.value = object.at(bound.key).number();
  }
  object.read("listed", parameter.listed);
  if (!(parameter.lower <= parameter.upper)) object.refuse("lower at most upper");
  if (!(parameter.search_lower <= parameter.search_upper)) object.refuse("search_lower at most search_upper");
  return parameter;
}

/// @param keys  of term k of n: its coefficient and its order
template <typename Keys>
std::vector<StructureTerm> read_terms(const Node& node, const Keys& keys) {
  const std::vector<Node> list = node.list();
  if (list.empty() || list.size() > kMostTerms) node.refuse(fmt::format("1 to {} terms", kMostTerms));
  std::vector<StructureTerm> terms;
  for (std::size_t k = 0; k < list.size(); ++k) {
    const Node term = list[k].object({"coefficient", "order"});
    auto [coefficient, order] = keys(k, list.size());
    terms.push_back({.coefficient = read_parameter(term.at("coefficient"), std::move(coefficient)),
                     .order = read_parameter(term.at("order"), std::move(order))});
  }
  return terms;
}

InputMap read_map(const Node& node) {
  const Node object = node.object({"bias", "null", "dead_band", "negative_gain_ratio"});
  InputMap map;
  map.bias = read_parameter(object.at("bias"), input_bias_key());
  if (!object.has("null")) return map;
  map.valve = ValveParameters{
      .null = read_parameter(object.at("null"), valve_null_key()),
      .dead_band = read_parameter(object.at("dead_band"), dead_band_key()),
      .negative_gain_ratio = read_parameter(object.at("negative_gain_ratio"), negative_gain_ratio_key())};
  return map;
}

GreyBoxStructure read_box_structure(const Node& node) {
  std::string name;
  node.at("kind").read(name);
  for (const GreyBoxKind* kind : grey_box_kinds()) {
    if (kind->name != name) continue;
    GreyBoxStructure box{kind, {}};
    for (std::size_t i = 0; i < kind->parameters.size(); ++i) {
      const std::string key(kind->parameters[i].name);
      box.parameters.push_back(read_parameter(node.at(key.c_str()), grey_box_key(key, i)));
    }
    return box;
  }
  node.at("kind").refuse("the name of a grey box");
}

Degrees read_degrees(const Node& node) {
  const Node object = node.object({"poles", "zeros"});
  Degrees degrees;
  object.at("poles").read(degrees.poles);
  object.at("zeros").read(degrees.zeros);
  if (degrees.poles < 1 || degrees.poles > kMostDegrees || degrees.zeros < 0 || degrees.zeros > degrees.poles) {
    object.refuse(fmt::format("1 to {} poles and at most as many zeros", kMostDegrees));
  }
  return degrees;
}

ParameterRequest read_request(const Node& node) {
  const Node object = node.object({"name", "fixed", "start", "lower", "upper"});
  ParameterRequest request;
  object.at("name").read(request.name);
  if (object.has("fixed")) object.at("fixed").read(request.fixed.emplace());
  if (object.has("start")) request.start = object.at("start").number();
  if (object.has("lower")) request.lower = object.at("lower").number();
  if (object.has("upper")) request.upper = object.at("upper").number();
  return request;
}

}  // namespace

OrderedJson structure_to_json(const StructureOptions& asked) {
  const Structure& structure = asked.structure;
  OrderedJson object{{"family", structure.family}, {"formula", structure.formula}};
  if (structure.degrees) object["degrees"] = {{"poles", structure.degrees->poles}, {"zeros", structure.degrees->zeros}};
  object["numerator"] = to_json(structure.numerator);
  object["denominator"] = to_json(structure.denominator);
  if (structure.base_order) object["base_order"] = to_json(*structure.base_order);
  if (structure.grey_box) {
    OrderedJson box{{"kind", structure.grey_box->kind->name}};
    for (const StructureParameter& parameter : structure.grey_box->parameters) {
      box[parameter.key.name] = to_json(parameter);
    }
    object["grey_box"] = std::move(box);
  }
  object["delay"] = to_json(structure.delay);
  object["input_map"] = to_json(structure.input_map);
  object["initial_output"] = to_json(structure.initial_output);
  object["initial_state"] = name_in(kInitialStates, asked.initial_state);
  if (!asked.parameters.empty()) {
    OrderedJson requests = OrderedJson::array();
    for (const ParameterRequest& request : asked.parameters) requests.push_back(to_json(request));
    object["parameters"] = std::move(requests);
  }
  return object;
}

StructureOptions read_structure(const Node& node) {
  const Node object = node.object({"family", "formula", "degrees", "numerator", "denominator", "base_order", "grey_box",
                                   "delay", "input_map", "initial_output", "initial_state", "parameters"});
  StructureOptions asked;
  Structure structure;
  object.at("family").read(structure.family);
  object.read("formula", structure.formula);
  if (object.has("degrees")) structure.degrees = read_degrees(object.at("degrees"));
  structure.numerator = read_terms(object.at("numerator"), [](std::size_t k, std::size_t terms) {
    return std::pair(numerator_key(k, terms), numerator_order_key(k, terms));
  });
  structure.denominator = read_terms(
      object.at("denominator"), [](std::size_t k, std::size_t) { return std::pair(coefficient_key(k), order_key(k)); });
  if (object.has("base_order")) structure.base_order = read_parameter(object.at("base_order"), base_order_key());
  if (object.has("grey_box")) structure.grey_box = read_box_structure(object.at("grey_box"));
  structure.delay = read_parameter(object.at("delay"), delay_key());
  structure.input_map = read_map(object.at("input_map"));
  structure.initial_output = read_parameter(object.at("initial_output"), initial_output_key());
  if (object.has("initial_state")) read_name(object.at("initial_state"), kInitialStates, asked.initial_state);
  if (object.has("parameters")) {
    for (const Node& entry : object.at("parameters").list()) asked.parameters.push_back(read_request(entry));
  }
  asked.structure = std::move(structure);
  return asked;
}

}  // namespace eha::ident
