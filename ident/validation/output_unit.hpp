// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/display_unit.hpp"
#include "ident/model/model.hpp"
#include "ident/structure/parameter_role.hpp"
#include "ident/validation/parameter_change.hpp"

namespace eha::ident {

/// Whether a parameter's value is proportional to the output's unit.
[[nodiscard]] bool scales_with_output(ParameterRole role);

/// The model whose output is in another unit: gain, offset, free response, scores, Bode plot and the sentences of its
/// verdict. @param factor  what an output in the model's unit is multiplied by, positive
[[nodiscard]] Model in_output_unit(Model model, const std::string& unit, double factor);

/// The same of a change's figures.
[[nodiscard]] PlantChange in_output_unit(PlantChange change, double factor);

/// The model with its output in a unit for people, where that is a length.
[[nodiscard]] Model in_unit(Model model, const DisplayUnit& unit);

/// A text with each reason of a model's verdict that it quotes, as recommendations do, replaced by the same reason of
/// the model in another unit.
[[nodiscard]] std::string requoted(std::string text, const Model& before, const Model& after);

}  // namespace eha::ident
