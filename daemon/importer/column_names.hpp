// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/unit_names.hpp"

namespace eha::importer {

/// The unit that a mistyped one is likely to mean: "mn" mm, "Mm" mm; empty for a known one and where nothing is likely.
[[nodiscard]] std::string unit_meant(std::string_view text);

/// Whether a field of a row below the header can be a unit: a known one, anything in brackets, "-" or nothing.
[[nodiscard]] bool may_be_unit(std::string_view field);

/// The text of a unit without its brackets, as the project writes it where it knows it.
[[nodiscard]] std::string unit_of(std::string_view field);

/// Splits a column's label into name and unit: "Spannung [V]", "Weg (mm)", "t / s", "Zeit in s", "u_V". A unit that is
/// not in brackets must be a known one. Of a column named after a unit of time, "millis", and of "Time ms" it is that
/// one. No unit: empty.
[[nodiscard]] std::pair<std::string, std::string> name_and_unit(std::string_view label);

/// Splits "Zeit ms" and "Weg mm" where the last word of every label is a known unit; else empty, as "Channel A" is no
/// current.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> names_and_last_units(
    const std::vector<std::string>& labels);

/// Seconds in one unit of time; none when it is no unit of time.
[[nodiscard]] std::optional<double> seconds_in(std::string_view unit);

/// Longest name or field in a message [bytes].
inline constexpr std::size_t kLongestShown = 40;

/// A name for a message: letters of every language stay, control characters and what is no UTF-8 become '?', and what
/// is beyond `length` bytes becomes "...".
[[nodiscard]] std::string readable(std::string_view name, std::size_t length);

/// How strongly a column's name and unit say that it is of a kind: 0 nothing, 1 the unit, 2 the name, 3 both.
struct Hints {
  int time = 0;
  int input = 0;
  int output = 0;
  int index = 0;  ///< 0 or 2: a column that numbers the rows
  /// A set point of the rod's place, also in volts, a force, a pressure, a temperature or what surrounds the plant: no
  /// input that is taken unasked.
  bool is_beside = false;
  bool is_set_point = false;  ///< of the rod's place: no output that is taken unasked
  /// Named as a set point, in a unit of an input: one where another column is the input, as a controller's output is.
  bool is_demand_as_input = false;
  bool is_valve_feedback = false;  ///< what a valve reports of its own spool or current: no output taken unasked
  bool is_pressure = false;        ///< or a force
  bool is_temperature = false;     ///< never the time
  bool is_ambient = false;         ///< of what surrounds the plant
  bool names_temperature = false;  ///< whatever its unit
  bool is_letter_t = false;        ///< "T" without a unit: a temperature beside a clock, else what its values say
};
[[nodiscard]] Hints hints_of(std::string_view name, std::string_view unit);

}  // namespace eha::importer
