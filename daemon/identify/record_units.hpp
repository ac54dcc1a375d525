// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/identify/source.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// Converts the model to the record's units: both units are the same, or both are lengths, voltages or currents. An
/// unknown (empty) unit counts as the other one.
/// @param name  of the model, for the message
/// @throws DataError  the units are of different kinds
[[nodiscard]] ident::Model in_units_of(const Source& source, ident::Model model, const std::string& name);

/// Says which channel has a unit in the model or in the record alone, so that in_units_of() takes both to be the same;
/// empty where none has.
[[nodiscard]] std::string unit_taken_as_same(const Source& source, const ident::Model& model);

/// Converts all models to the units of the first in the same way. @param names  of the models, for the message
[[nodiscard]] std::vector<ident::Model> in_units_of_first(std::vector<ident::Model> models,
                                                          const std::vector<std::string>& names);

/// Converts all records to the units of the first.
[[nodiscard]] std::vector<Source> in_units_of_first(std::vector<Source> sources);

}  // namespace eha::identify
