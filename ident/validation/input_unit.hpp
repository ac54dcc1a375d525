// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Converts a model to another input unit: gain, bias, valve map, past input, Bode plot and the sentences of its
/// verdict. @param factor  multiplies an input in the model's unit, positive
[[nodiscard]] Model in_input_unit(Model model, const std::string& unit, double factor);

}  // namespace eha::ident
