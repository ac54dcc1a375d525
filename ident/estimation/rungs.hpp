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

/// The rungs of the ladder without a map, in its order.
[[nodiscard]] std::vector<Rung> rungs_of(const LadderOptions& wanted);

}  // namespace eha::ident
