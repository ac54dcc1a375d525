// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/estimation/ladder.hpp"

namespace eha::ident {

/// A name and the structures that may bear it.
struct Rung {
  std::string name;
  std::vector<Structure> structures;
  Search search;
};

/// Rungs that start from one another, in their order.
using Chain = std::vector<Rung>;
/// Chains that start from those of earlier stages alone: no structure of one lies inside one of another.
using FitStage = std::vector<Chain>;

/// The rungs of the ladder without a map. Chain by chain they stand in its order.
[[nodiscard]] std::vector<FitStage> stages_of(const LadderOptions& wanted);

}  // namespace eha::ident
