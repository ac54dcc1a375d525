// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include "core/display_unit.hpp"
#include "daemon/eha/console.hpp"

namespace eha::cli {

/// Prints where a placing has left the rod. @param displacement_in  [in]
inline void print_place(double displacement_in, const Console& console) {
  const DisplayUnit unit(console.units());
  console.print(fmt::format("the rod is at {:.3f} {}; the hydraulics are off", unit.factor("in") * displacement_in,
                            unit.of("in")));
  console.next_step("eha read");
}

}  // namespace eha::cli
