// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "ident/validation/parameter_change.hpp"

namespace eha::cli {

/// "dead_band moved by 0.1 V, joint +- 0.003 V (0.148 to 0.248)"
[[nodiscard]] std::string change_sentence(const ident::ParameterChange& change, const ident::Model& model);

/// Returns one line for each parameter that changed, one that says whose number a changed null or dead band is, one for
/// each parameter whose change another one hides, and one for each that the records do not determine.
[[nodiscard]] std::string change_sentences(const ident::PlantChange& change, const ident::Model& model);

[[nodiscard]] nlohmann::ordered_json change_json(const ident::PlantChange& change, const ident::Model& model);

}  // namespace eha::cli
