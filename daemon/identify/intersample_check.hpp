// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Whether the input of a file was taken as held between its rows although the record contradicts it: the recommended
/// model, fitted again both ways, has a clearly lower AR-BIC with an input that is straight between the rows; or one
/// without its zero and dead time, which may have stood for half a row alone, has a lower one so. Where a
/// zero or dead time has taken up the half row, and steps do not describe the record clearly better than a smooth input
/// (lines of a fast input err as steps do), it says what half a row changes.
/// @param command  fits the record with a straight input
/// @returns a sentence with the errors or the half row, and the command; nothing where the input is held, or as good as
/// held,
///          and for records of more than a million rows
/// Cost: three to five fits from a known model on ident::kPartsOfARow times the rows.
[[nodiscard]] std::optional<std::string> intersample_advice(const Source& source, const IdentificationTask& task,
                                                            const Identification& identification,
                                                            const std::string& command);

}  // namespace eha::identify
