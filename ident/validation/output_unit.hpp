// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/display_unit.hpp"
#include "ident/model/model.hpp"
#include "ident/structure/parameter_role.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::ident {

/// Whether a parameter's value is proportional to the output's unit.
[[nodiscard]] bool scales_with_output(const ParameterKey& key);

/// Converts a model to another output unit: gain, offset, free response, scores, Bode plot and the sentences of its
/// verdict. @param factor  multiplies an output in the model's unit, positive
[[nodiscard]] Model in_output_unit(Model model, const std::string& unit, double factor);

/// Converts the figures of a change in the same way.
[[nodiscard]] PlantChange in_output_unit(PlantChange change, double factor);

/// Converts a model to the display unit of lengths, if its output is a length.
[[nodiscard]] Model in_unit(Model model, const DisplayUnit& unit);

/// Replaces the reasons of a model's verdict that a text quotes (as recommendations do) by the same reasons of the
/// model in another unit.
[[nodiscard]] std::string requoted(std::string text, const Model& before, const Model& after);

}  // namespace eha::ident
