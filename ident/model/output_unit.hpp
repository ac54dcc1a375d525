// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"
#include "ident/structure/parameter_role.hpp"

namespace eha::ident {

/// Whether a parameter's value is proportional to the output's unit.
[[nodiscard]] bool scales_with_output(ParameterRole role);

/// The model whose output is in another unit: gain, offset, free response, scores, Bode plot and the sentences of its
/// verdict. @param factor  what an output in the model's unit is multiplied by, positive
[[nodiscard]] Model in_output_unit(Model model, const std::string& unit, double factor);

}  // namespace eha::ident
