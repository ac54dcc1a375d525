// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/importer/dialect.hpp"
#include "daemon/importer/importer_options.hpp"

namespace eha::importer {

/// Begins a comment above the header of a record that was imported from a file with a set point of the rod.
inline constexpr std::string_view kClosedLoopComment = "# closed loop";

/// The sample period that a program writes above its rows [s]: "HResolution" of Yokogawa, "Increment" of Rigol, "Sample
/// Interval", "Delta_X", or one over a "SampleRate" in Hz. The value stands behind its name, as in "Abtastrate: 200
/// Hz", or below it. None where no line says one, or where two differ.
/// @param lines  the file's first, of which those above dialect.first_data_line are looked at
[[nodiscard]] std::optional<double> period_above_rows(const std::vector<std::string>& lines, const Dialect& dialect);

/// The sample period that a number with such a name gives, "Ts", "dt", "SampleTime", or one over "fs", "SampleRate" in
/// Hz [s]; none for other names and for numbers that are not positive. A unit of time behind the name counts:
/// "SampleTime[ms]".
[[nodiscard]] std::optional<double> period_named(std::string_view name, double value);

/// Refuses a log that has one row for each variable and time, as WinCC writes it ("VarName";"TimeString";"VarValue"),
/// with a command that writes a column for each variable. @throws DataError
void refuse_long_log(const Dialect& dialect, const std::filesystem::path& path, const Options& options);

}  // namespace eha::importer
