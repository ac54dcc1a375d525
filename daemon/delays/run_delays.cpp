// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/delays/run_delays.hpp"

#include <unistd.h>

#include <algorithm>

#include "core/priorities.hpp"

namespace eha::delays {

std::vector<Delay> delays_of_run(const Counters& before, const config::RealtimeOptions& realtime,
                                 const acquisition::RunReport& report) {
  constexpr const char* kRoot = "/";
  LoopThread loop{.cpu = {}, .priority = 0, .process = getpid()};
  if (report.realtime.cpu_bound) loop.cpu = realtime.cpu;
  // With ordinary scheduling every real-time thread takes precedence.
  if (report.realtime.fifo) {
    loop.priority = std::min(realtime.priority, kHighestLoopPriority);
    loop.preemptions = report.counters.involuntary_switches;
  }
  return seen_delays(kRoot, before, read_counters(kRoot), loop);
}

nlohmann::ordered_json to_json(const Delay& delay) {
  return {{"name", delay.name}, {"found", delay.found}, {"remedy", delay.remedy}};
}

}  // namespace eha::delays
