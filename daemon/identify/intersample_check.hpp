// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Whether the input of a file was taken as held between its rows although the record contradicts it: the recommended
/// model, fitted again both ways, has a clearly lower AR-BIC with an input that is straight between the rows; or one
/// without its zero and dead time, which may have stood for half a row alone, has a lower one so.
/// @param command  fits the record with a straight input
/// @returns a sentence with the two errors and the command; nothing where the input is held, or as good as held,
///          and for records of more than a million rows
/// Cost: two fits from a known model, or three, on ident::kPartsOfARow times the rows.
[[nodiscard]] std::optional<std::string> intersample_advice(const Source& source, const IdentificationTask& task,
                                                            const Identification& identification,
                                                            const std::string& command);

}  // namespace eha::identify
