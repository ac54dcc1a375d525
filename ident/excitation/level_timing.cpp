// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/level_timing.hpp"

#include <fmt/format.h>

namespace eha::ident {

std::vector<OptionIssue> check_hold(double hold_s, double step_s, double duration_s) {
  if (hold_s >= step_s && hold_s < duration_s) return {};
  return {{"hold_s", fmt::format("expected a time from one tick, {} s, to less than duration_s = {}, got {}", step_s,
                                 duration_s, hold_s)}};
}

}  // namespace eha::ident
