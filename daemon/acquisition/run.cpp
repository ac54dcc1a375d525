// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/run.hpp"

#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>

#include "core/error.hpp"
#include "daemon/acquisition/fatal_signals.hpp"
#include "daemon/acquisition/loop.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/acquisition/tick_engine.hpp"

namespace eha::acquisition {
namespace {

constexpr std::size_t kLoopStack = 1024 * 1024;
constexpr double kGreatestPeriod_s = 1.0;
constexpr double kLeastPeriod_s = 1e-4;

void check(const CommandSource& source, const config::RigLimits& limits, const config::RealtimeOptions& realtime,
           const hal::RigCapabilities& rig) {
  require(realtime.sample_period_s >= kLeastPeriod_s && realtime.sample_period_s <= kGreatestPeriod_s,
          "sample period: expected 0.0001 to 1 s, got " + std::to_string(realtime.sample_period_s) + " s");
  require(source.rows() >= 1 && source.rows() <= kMostRows && source.rows_per_repetition() >= 1,
          "the run has no rows, or more than 2147483647");
  require(limits.command_min_V < limits.command_max_V && limits.safe_V >= limits.command_min_V &&
              limits.safe_V <= limits.command_max_V,
          "rig limits: the safe voltage must lie between command_min_V and command_max_V");
  require(limits.command_min_V >= rig.command_min_V && limits.command_max_V <= rig.command_max_V,
          "rig limits: command_min_V to command_max_V must lie within the output range " +
              std::to_string(rig.command_min_V) + " to " + std::to_string(rig.command_max_V) + " V");
  require(limits.slew_V_per_s > 0.0 && std::isfinite(limits.slew_V_per_s), "rig limits: slew_V_per_s must be positive");
  require(limits.travel_min_in < limits.travel_max_in, "rig limits: travel_min_in must be below travel_max_in");
  require(limits.stopping_deceleration_in_per_s2 > 0.0, "rig limits: stopping_deceleration_in_per_s2 must be positive");
  require(limits.velocity_limit_in_per_s > 0.0, "rig limits: velocity_limit_in_per_s must be positive");
  require(limits.frozen_sensor_s >= 0.0, "rig limits: frozen_sensor_s must not be negative");
}

/// Runs `work` in a thread with a stack of its own size and waits for it.
void run_in_thread(const std::function<void()>& work) {
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, kLoopStack);
  pthread_t thread{};
  const int error = pthread_create(
      &thread, &attributes,
      [](void* argument) -> void* {
        (*static_cast<const std::function<void()>*>(argument))();
        return nullptr;
      },
      const_cast<void*>(static_cast<const void*>(&work)));
  pthread_attr_destroy(&attributes);
  if (error == 0) pthread_setname_np(thread, "eha-loop");
  if (error != 0) {
    throw Error(ExitCode::io, "cannot start the loop's thread: " + error_text(error));
  }
  pthread_join(thread, nullptr);
}

}  // namespace

RunReport run(hal::Rig& rig, StateMachine& machine, CommandSource& source, const config::RigLimits& limits,
              const config::RealtimeOptions& realtime, NonRealtime non_realtime, Clock& clock, RecordQueue& queue,
              const StopRequest& stop, StatusBoard& board, GuardPage* page, EarlierRuns* earlier) {
  check(source, limits, realtime, rig.capabilities());
  require(machine.state() == State::armed,
          "the rig is " + std::string(to_text(machine.state())) + ", not armed; arm it first");
  require(!clock.is_virtual() || rig.capabilities().has_virtual_clock,
          "virtual time is for simulated rigs; this one (" + rig.capabilities().backend + ") keeps real time");
  RunReport report;
  const bool moves_nothing = !rig.capabilities().moves_machine;
  const auto play = [&](LatePolicy policy) {
    const SignalStack signal_stack;
    mark_loop_thread();
    TickEngine engine(rig, machine, source, limits, realtime, policy, clock,
                      earlier != nullptr ? *earlier : EarlierRuns{});
    const std::int64_t period_ns = std::llround(realtime.sample_period_s * 1e9);
    const LoopLinks links{clock, queue, stop, board, page, stall_limit_ns(realtime, kernel_facts())};
    Loop(engine, machine, period_ns, links, report).run();
    if (earlier != nullptr) *earlier = engine.left();
  };
  if (clock.is_virtual()) {
    play(LatePolicy::abort);
    return report;
  }
  const RealtimeProcess process(report.realtime);
  bool refused = false;
  run_in_thread([&] {
    block_all_but_fatal_signals();
    enter_realtime(realtime, report.realtime);
    const bool granted = report.realtime.fifo && report.realtime.memory_locked;
    refused = !granted && non_realtime == NonRealtime::refuse && !moves_nothing;
    if (!refused) play(moves_nothing ? LatePolicy::count : LatePolicy::abort);
  });
  if (refused) {
    std::string message = "no real-time scheduling, and this rig really moves:";
    for (const std::string& sentence : report.realtime.refused) message += "\n" + sentence;
    throw PermissionError(message + "\nrun it through ehad, or on a bench allow it with --allow-non-realtime");
  }
  return report;
}

}  // namespace eha::acquisition
