// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "daemon/importer/dialect.hpp"

// What an oscilloscope of Tektronix writes about its channels.
//   above the rows  "Sample Interval,4e-05", "Vertical Units,V,V", "Label,Valve,Rod", "TIME,CH1,CH2"
//                   (MDO, MSO 4 to 6; also behind '#', and as blocks side by side: "TIME,CH1,,TIME,CH2")
//   beside them     "Record Length,2500,,-0.05,1.2," in the first rows, ",,,-0.04,1.3," in the others (TDS, TBS)

namespace eha::importer {

/// The line, from 0, that names the columns below such a block; none for other files.
[[nodiscard]] std::optional<std::size_t> scope_header_line(const std::vector<std::string>& lines);

/// Takes names and units of the columns from such a block. @param header_line  as scope_header_line() has it
void take_facts_above(const std::vector<std::string>& lines, std::size_t header_line, Dialect& dialect);

/// Takes names and units from facts beside the rows, whose columns are no columns of the record. @returns whether any
bool take_facts_beside(const std::vector<std::string>& lines, Dialect& dialect);

}  // namespace eha::importer
