// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace eha::ident {

/// The role of a model's parameter. Code depends on the role of a parameter, never on its name.
enum class ParameterRole {
  numerator_coefficient,
  denominator_coefficient,
  numerator_order,
  denominator_order,
  base_order,           ///< q: term k of numerator and denominator has order k q
  delay,                ///< transport delay [s]
  input_bias,           ///< of the static map before G [input unit]
  valve_null,           ///< of the valve map before G, as the next two [input unit]
  dead_band,            ///< half width [input unit]
  negative_gain_ratio,  ///< gain below the dead band over the gain above it
  initial_output,       ///< permanent offset [output unit]
  initial_state,        ///< term of the free response of a finite state
  past_input,           ///< input in one window before t = 0 [input unit]
  grey_box,             ///< of a grey box, the index counts in its kind's list
};

/// One parameter of a model. Terms are counted from the lowest order.
struct ParameterKey {
  std::string name;  ///< as in model files
  ParameterRole role = ParameterRole::denominator_coefficient;
  std::size_t index = 0;  ///< index of the term, state or window; 0 if there is only one

  bool operator==(const ParameterKey&) const = default;
};

/// Whether a parameter is an exponent of s, or scales all exponents.
[[nodiscard]] bool is_order(ParameterRole role);

/// Whether a parameter multiplies a power of s.
[[nodiscard]] bool is_coefficient(ParameterRole role);

/// Whether a parameter is one of the valve map before G.
[[nodiscard]] bool is_of_map(ParameterRole role);

/// Whether a parameter describes the state at t = 0. It enters the output linearly and takes no request.
[[nodiscard]] bool is_free_response(ParameterRole role);

/// Whether a parameter shifts the record rather than shapes the plant: bias, valve null, offset, free response.
[[nodiscard]] bool is_offset(ParameterRole role);

/// Returns the least physical value: 0 for a dead band and a delay, else minus infinity (a grey box's kind has its
/// own).
[[nodiscard]] double least_value(ParameterRole role);

/// The keys of model files, spelled here only. Denominator term i has coefficient "a<i>" and order "n<i>". One
/// numerator term has coefficient "K" and order "b0", several have "b<j>" and "m<j>".
[[nodiscard]] ParameterKey coefficient_key(std::size_t index);
[[nodiscard]] ParameterKey order_key(std::size_t index);
[[nodiscard]] ParameterKey numerator_key(std::size_t index, std::size_t terms);
[[nodiscard]] ParameterKey numerator_order_key(std::size_t index, std::size_t terms);
[[nodiscard]] ParameterKey base_order_key();
[[nodiscard]] ParameterKey delay_key();
[[nodiscard]] ParameterKey input_bias_key();
[[nodiscard]] ParameterKey valve_null_key();
[[nodiscard]] ParameterKey dead_band_key();
[[nodiscard]] ParameterKey negative_gain_ratio_key();
[[nodiscard]] ParameterKey initial_output_key();
[[nodiscard]] ParameterKey state_key(std::size_t index);
/// The latest window has index 0.
[[nodiscard]] ParameterKey past_input_key(std::size_t index);
/// The key of a grey box's parameter, named by its kind.
[[nodiscard]] ParameterKey grey_box_key(std::string_view name, std::size_t index);

/// Returns the key of a name read from a model file. An unknown name counts as a coefficient of the denominator.
/// @param numerator_terms  of the model: "b0" is an order if there is one term, otherwise a coefficient
[[nodiscard]] ParameterKey key_of(std::string_view name, std::size_t numerator_terms);

}  // namespace eha::ident
