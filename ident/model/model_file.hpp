// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// A model as JSON text, schema "eha-model/1": keys in a fixed order, numbers in the fewest digits that give the same
/// number back, numbers that are not finite as null, a final newline. Same model, same bytes.
[[nodiscard]] std::string to_text(const Model& model);

/// Reads what to_text() writes. Only `transfer_function` is needed; everything else has Model's defaults.
/// @param file_name  for messages; its stem names a model without a name
/// @throws ConfigError  names the file and the place: line and column where the text is not JSON, else the JSON path
///                      ("transfer_function.denominator[1].order") of a missing, misspelt or wrong field
/// Safe for untrusted text of any size, depth and encoding. Cost O(length).
[[nodiscard]] Model model_from_text(std::string_view text, const std::string& file_name);

}  // namespace eha::ident
