// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/delay_checks.hpp"

#include <fmt/format.h>

namespace eha::doctor {

std::vector<Check> check_delays(const std::vector<delays::Delay>& standing, std::optional<int> cpu) {
  std::vector<Check> checks;
  for (const delays::Delay& delay : standing) checks.push_back(warn(delay.name, delay.found, delay.remedy));
  if (!checks.empty()) return checks;
  return {ok("late ticks", cpu ? fmt::format("nothing is known that holds CPU {} up", *cpu)
                               : "nothing is known that holds the loop up; of a loop bound to a CPU (realtime.cpu) "
                                 "more is known")};
}

}  // namespace eha::doctor
