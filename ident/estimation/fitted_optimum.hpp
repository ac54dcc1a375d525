// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit_choice.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// Where a fit ended, to go on from.
struct FittedOptimum {
  StructureOptions asked;     ///< of the caller
  StructureOptions searched;  ///< the same with what the record's start decides
  Parametrisation::Scale scale;
  LocalOptimum optimum;  ///< without its Jacobian
};

}  // namespace eha::ident
