// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/structure/parameter_role.hpp"

#include <array>
#include <charconv>
#include <limits>
#include <optional>

#include "ident/grey_box/grey_box_kind.hpp"

namespace eha::ident {
namespace {

constexpr std::string_view kGain = "K";
constexpr std::string_view kGainOrder = "b0";
constexpr std::string_view kPastInput = "past_input_";

struct Prefix {
  std::string_view text;
  ParameterRole role;
};
constexpr std::array<Prefix, 6> kPrefixes = {{{"a", ParameterRole::denominator_coefficient},
                                              {"n", ParameterRole::denominator_order},
                                              {"b", ParameterRole::numerator_coefficient},
                                              {"m", ParameterRole::numerator_order},
                                              {"x", ParameterRole::initial_state},
                                              {kPastInput, ParameterRole::past_input}}};
constexpr std::array<Prefix, 7> kSingle = {{{"q", ParameterRole::base_order},
                                            {"delay_s", ParameterRole::delay},
                                            {"input_bias", ParameterRole::input_bias},
                                            {"null", ParameterRole::valve_null},
                                            {"dead_band", ParameterRole::dead_band},
                                            {"negative_gain_ratio", ParameterRole::negative_gain_ratio},
                                            {"initial_output", ParameterRole::initial_output}}};

ParameterKey numbered(ParameterRole role, std::size_t index) {
  for (const Prefix& prefix : kPrefixes) {
    if (prefix.role == role) return {std::string(prefix.text) + std::to_string(index), role, index};
  }
  return {};
}

ParameterKey single(ParameterRole role) {
  for (const Prefix& whole : kSingle) {
    if (whole.role == role) return {std::string(whole.text), role, 0};
  }
  return {};
}

std::optional<std::size_t> number_of(std::string_view digits) {
  std::size_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size()) return {};
  return value;
}

}  // namespace

bool is_order(ParameterRole role) {
  return role == ParameterRole::denominator_order || role == ParameterRole::numerator_order ||
         role == ParameterRole::base_order;
}

bool is_coefficient(ParameterRole role) {
  return role == ParameterRole::numerator_coefficient || role == ParameterRole::denominator_coefficient;
}

bool is_of_map(ParameterRole role) {
  return role == ParameterRole::valve_null || role == ParameterRole::dead_band ||
         role == ParameterRole::negative_gain_ratio;
}

bool is_free_response(ParameterRole role) {
  return role == ParameterRole::initial_state || role == ParameterRole::past_input;
}

bool is_offset(ParameterRole role) {
  return role == ParameterRole::input_bias || role == ParameterRole::valve_null ||
         role == ParameterRole::initial_output || is_free_response(role);
}

double least_value(ParameterRole role) {
  const bool is_a_size = role == ParameterRole::dead_band || role == ParameterRole::delay;
  return is_a_size ? 0.0 : -std::numeric_limits<double>::infinity();
}

ParameterKey coefficient_key(std::size_t index) { return numbered(ParameterRole::denominator_coefficient, index); }
ParameterKey order_key(std::size_t index) { return numbered(ParameterRole::denominator_order, index); }

ParameterKey numerator_key(std::size_t index, std::size_t terms) {
  if (terms == 1) return {std::string(kGain), ParameterRole::numerator_coefficient, 0};
  return numbered(ParameterRole::numerator_coefficient, index);
}

ParameterKey numerator_order_key(std::size_t index, std::size_t terms) {
  if (terms == 1) return {std::string(kGainOrder), ParameterRole::numerator_order, 0};
  return numbered(ParameterRole::numerator_order, index);
}

ParameterKey base_order_key() { return single(ParameterRole::base_order); }
ParameterKey delay_key() { return single(ParameterRole::delay); }
ParameterKey input_bias_key() { return single(ParameterRole::input_bias); }
ParameterKey valve_null_key() { return single(ParameterRole::valve_null); }
ParameterKey dead_band_key() { return single(ParameterRole::dead_band); }
ParameterKey negative_gain_ratio_key() { return single(ParameterRole::negative_gain_ratio); }
ParameterKey initial_output_key() { return single(ParameterRole::initial_output); }
ParameterKey state_key(std::size_t index) { return numbered(ParameterRole::initial_state, index); }
ParameterKey past_input_key(std::size_t index) { return numbered(ParameterRole::past_input, index); }

ParameterKey grey_box_key(std::string_view name, std::size_t index) {
  return {std::string(name), ParameterRole::grey_box, index};
}

ParameterKey key_of(std::string_view name, std::size_t numerator_terms) {
  if (name == kGain) return numerator_key(0, 1);
  if (name == kGainOrder && numerator_terms == 1) return numerator_order_key(0, 1);
  for (const Prefix& whole : kSingle) {
    if (name == whole.text) return single(whole.role);
  }
  for (const GreyBoxKind* kind : grey_box_kinds()) {
    const std::size_t index = index_of(*kind, name);
    if (index < kind->parameters.size()) return grey_box_key(name, index);
  }
  for (const Prefix& prefix : kPrefixes) {
    if (!name.starts_with(prefix.text)) continue;
    if (const auto index = number_of(name.substr(prefix.text.size()))) return numbered(prefix.role, *index);
  }
  return {std::string(name), ParameterRole::denominator_coefficient, 0};
}

}  // namespace eha::ident
