// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "ident/model/model.hpp"

namespace eha::report {

/// What tells one of several models of a record from the others.
struct RankedModel {
  std::string label;
  double rms_error = 0.0;      ///< on the samples that score them all [unit]
  std::size_t parameters = 0;  ///< estimated ones
  std::string but = {};        ///< why not to use it: "rejected", "of another plant"; empty: nothing speaks against it
};

/// How many parameters of a model were estimated.
[[nodiscard]] std::size_t estimated_parameters(const ident::Model& model);

/// Which model to use, by what measure, and why none of the others: "use a: rms error 0.0021 in, b 0.0092 in, 4.4 times
/// as much". Models whose errors differ by less than ident::kGreatestErrorOverRefit describe a record alike; of these
/// it is the one with the fewest parameters. @param models  at least one
[[nodiscard]] std::string better_model(std::vector<RankedModel> models, const std::string& unit);

}  // namespace eha::report
