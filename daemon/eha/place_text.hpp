// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>

#include "core/display_unit.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/place/place_controller.hpp"

namespace eha::cli {

/// Prints the position to which a placing has moved the rod.
/// @param displacement_in  [in]   @param units  of the rig file   @param next  command that shows it again
inline void print_place(double displacement_in, const std::string& units, const std::string& next,
                        const Console& console) {
  const DisplayUnit unit = console.unit(units);
  const double factor = unit.factor("in");
  console.print(fmt::format("the rod is at {0:.3f} {1} (tolerance {2:.2g} {1}); nothing drives it",
                            factor * displacement_in, unit.of("in"), factor * place::kTolerance_in));
  console.next_step(next);
}

}  // namespace eha::cli
