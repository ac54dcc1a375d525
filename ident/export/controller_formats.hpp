// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ident/control/axis_controller.hpp"

namespace eha::ident {

/// A controller to export to a program or a PLC.
struct ExportedController {
  AxisCoefficients coefficients;
  std::vector<std::string> notes;  ///< for the head of the file, plain text; see controller_notes()
  std::string length_unit = "in";  ///< of positions, in the names of arguments
};

/// Converts a controller to positions in another unit; `factor` of the new unit make one of the old: 25.4 for mm.
[[nodiscard]] AxisSettings in_length_unit(AxisSettings settings, double factor);

/// An export format of a controller. A new one is a row of controller_formats() and a function.
struct ControllerFormat {
  std::string_view name;    ///< of --format
  std::string_view what;    ///< for --help
  std::string_view ending;  ///< of a file name
  /// The file's text, ending in a newline. @param function  an eha::identifier(); the name to call it by
  std::string (*text)(const ExportedController& controller, const std::string& function);
};

[[nodiscard]] std::span<const ControllerFormat> controller_formats();

// The formats, each in its file.
[[nodiscard]] std::string controller_c_text(const ExportedController& controller, const std::string& function);
[[nodiscard]] std::string controller_st_text(const ExportedController& controller, const std::string& function);
[[nodiscard]] std::string controller_octave_text(const ExportedController& controller, const std::string& function);
[[nodiscard]] std::string controller_python_text(const ExportedController& controller, const std::string& function);
[[nodiscard]] std::string controller_simulink_text(const ExportedController& controller, const std::string& function);

/// Returns the notes for a file's head: kind, gains, units, tick. The name is untrusted text and passes code_text().
[[nodiscard]] std::vector<std::string> controller_notes(const AxisCoefficients& coefficients, std::string_view name,
                                                        const std::string& length_unit);

/// Returns the controller's scalars by their names in the exported texts, in a fixed order.
[[nodiscard]] std::vector<std::pair<std::string, double>> controller_numbers(const AxisCoefficients& coefficients);

/// Formats a number so that every target language reads a real number.
[[nodiscard]] std::string real_text(double value);
/// Formats the numbers of a fractional filter, at least one: "0.1, 0.2".
[[nodiscard]] std::string real_list(const std::array<double, FractionalFilter::kLags>& values, std::size_t count);
/// Replaces each @NAME@ of a text.
[[nodiscard]] std::string with_values(std::string text, const std::vector<std::pair<std::string, std::string>>& values);

}  // namespace eha::ident
