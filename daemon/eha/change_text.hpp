// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "ident/validation/parameter_change.hpp"

namespace eha::cli {

/// What a difference of parameters shows.
enum class Shows {
  change,      ///< of the plant
  difference,  ///< which may come from the records
};

/// "dead_band moved by 0.1 V, joint +- 0.003 V (0.148 to 0.248)"; a mere difference "differs by".
[[nodiscard]] std::string change_sentence(const ident::ParameterChange& change, const ident::Model& model,
                                          Shows shows = Shows::change);

/// Returns a sentence for each parameter that changed, one that says whose number a changed null or dead band is, one
/// for each parameter whose change another one hides, and one for each that the records do not determine.
[[nodiscard]] std::vector<std::string> change_sentences(const ident::PlantChange& change, const ident::Model& model,
                                                        Shows shows = Shows::change);

/// The same, each in a line of its own, indented.
[[nodiscard]] std::string change_lines(const ident::PlantChange& change, const ident::Model& model,
                                       Shows shows = Shows::change);

[[nodiscard]] nlohmann::ordered_json change_json(const ident::PlantChange& change, const ident::Model& model);

}  // namespace eha::cli
