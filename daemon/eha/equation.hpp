// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"

namespace eha::cli {

/// A model in one line: "y = 2.9016 in + G (u + 0.3281 V), G = 0.13052 / (0.013241 s^2 + s + 0.0028495)".
/// @param factor, unit  the output is shown in `unit`, which is `factor` times the model's
[[nodiscard]] std::string equation(const ident::Model& model, double factor, const std::string& unit);

/// "0.013241 s^2 + s + 0.0028495". @param factor  of every coefficient
[[nodiscard]] std::string polynomial(const std::vector<ident::Term>& terms, double factor = 1.0);

}  // namespace eha::cli
