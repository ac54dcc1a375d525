// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/source.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// Converts the model's output to the record's unit: both units are the same, or both are lengths. An unknown (empty)
/// unit counts as the other one.
/// @param name  of the model, for the message
/// @throws DataError  the inputs differ in unit, or the outputs do and are no lengths
[[nodiscard]] ident::Model in_units_of(const Source& source, ident::Model model, const std::string& name);

}  // namespace eha::identify
