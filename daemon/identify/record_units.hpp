// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/source.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// The model with its output in the record's unit: both are the same, or both are lengths. A unit that is not known,
/// an empty one, is taken for the other's.
/// @param name  of the model, for the message
/// @throws DataError  inputs differ in unit, or the outputs do and are no lengths
[[nodiscard]] ident::Model in_units_of(const Source& source, ident::Model model, const std::string& name);

}  // namespace eha::identify
