// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

#include "ident/model/model.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/model/record_start.hpp"

namespace eha::cli {

/// Where the simulated output of a rod begins: a model that does not come to rest has the place of its own record.
/// @param factor, unit  of the place in the sentence, over that of the model
/// @returns none of any other model
inline std::optional<std::string> simulated_start(const ident::Model& model, double factor, const std::string& unit) {
  if (ident::comes_to_rest(model) || model.grey_box) return std::nullopt;
  return fmt::format(
      "the simulated output begins at {:.4g}{}, where the model's record began; beside an output that begins "
      "elsewhere it is off by that throughout",
      factor * model.initial_output, unit);
}

}  // namespace eha::cli
