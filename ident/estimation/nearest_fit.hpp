// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "ident/estimation/fit_choice.hpp"
#include "ident/model/model.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// A structure on the compared rows of a record.
struct NearestFit {
  const ComparedRecord& compared;
  const StructureOptions& asked;
  const Parametrisation::Scale& scale;
  double largest_input;  ///< [input unit]
  double first_input;    ///< [input unit]
  bool rests_before;     ///< the record is known to begin at rest
};

/// Searches the structure on the compared rows from one start of each variant: the known model that is one of the
/// structure, or its neighbour of another dead band or delay, that costs least there. The search ends early.
/// @returns the best of the variants; nothing where no known model is one of the structure, or all grow
/// Cost: about 25 simulations with derivatives a variant.
[[nodiscard]] std::optional<LocalOptimum> nearest_optimum(const NearestFit& fit, const std::vector<Model>& known,
                                                          Work& work);

}  // namespace eha::ident
