// SPDX-License-Identifier: GPL-3.0-or-later
// Plants that no transfer function describes, as data: a menu of kinds.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

namespace eha::ident {

/// Unit of a parameter of a grey box.
enum class GreyBoxUnit {
  rate_gain,  ///< output per input and second
  seconds,
  input,
  output,
  none,
};

struct GreyBoxParameter {
  std::string_view name;  ///< as in model files
  GreyBoxUnit unit = GreyBoxUnit::none;
  bool positive = true;  ///< greater than 0, and searched by its logarithm
};

/// A rational function without delay: gain / (a0 + a1 s + a2 s^2).
struct LinearForm {
  double gain = 0.0;
  std::array<double, 3> denominator = {};  ///< a0, a1, a2
};

/// What starts of a search are made of: the linear model of the record, and how far the record goes.
struct GreyBoxStart {
  LinearForm linear;
  double input_rms = 0.0;     ///< about its mean [input unit]
  double lowest_out = 0.0;    ///< of the output, from initial_output on [output unit]
  double greatest_out = 0.0;  ///< the same
};

/// A kind of plant with equations of its own:
///   y(t) = initial_output + z(t), z the first state, with the input v = u + input_bias held over each row.
/// At rest all states are 0. `advance` may be called with any part of a row, as a dead time needs.
struct GreyBoxKind {
  std::string_view name;     ///< of the family, in files and on the command line
  std::string_view formula;  ///< for tables
  std::string_view effect;   ///< what it adds to a transfer function, for sentences
  std::span<const GreyBoxParameter> parameters;
  std::size_t states = 0;
  bool integrates = false;         ///< its linear form has a pole at 0
  bool estimates_start = false;    ///< a record need not begin at rest
  bool bias_is_reference = false;  ///< input_bias is held at minus the mean input, about which the linear form holds

  /// Moves the states on by duration_s under a constant v. Allocates nothing. Preconditions: finite, duration_s >= 0.
  void (*advance)(const double* values, double* state, double v, double duration_s) = nullptr;
  /// The states at rest under a constant v; null of a kind whose records begin at rest.
  void (*at_rest)(const double* values, double v, double* state) = nullptr;
  /// The plant for small motions: about rest, or, of friction, while it moves one way.
  LinearForm (*linearised)(std::span<const double> values) = nullptr;
  /// Values worth a start of the search, at least one.
  std::vector<std::vector<double>> (*starts)(const GreyBoxStart& start) = nullptr;
};

// The kinds, each in its file.
[[nodiscard]] const GreyBoxKind& friction_kind();
[[nodiscard]] const GreyBoxKind& outflow_kind();
[[nodiscard]] const GreyBoxKind& overflow_kind();

/// Every kind, in the order of messages.
[[nodiscard]] std::span<const GreyBoxKind* const> grey_box_kinds();

/// Index of a parameter in a kind's list; as many as it has for an unknown name.
[[nodiscard]] std::size_t index_of(const GreyBoxKind& kind, std::string_view parameter);

}  // namespace eha::ident
