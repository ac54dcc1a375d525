// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/realtime_findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/measured_check.hpp"
#include "config/needs_following.hpp"
#include "core/priorities.hpp"

namespace eha {
namespace {

constexpr double kLongestTick_s = 0.05;  ///< reaction time of every check
/// Reaction time to a loop that stands still; a host that takes processors away needs 0.15 s.
constexpr double kLongestStall_s = 0.2;
/// The pulses for a valve that is not known: at 0.05 s they move a rod of 1.7 in/(V s) by 0.9 in, at 0.02 s by 0.56 in.
constexpr double kLongestTickOfPulses_s = 0.02;
/// With both gains a tenth of the rod's, an open wire that hums moves a rod at 5 ms by 0.46 in, at 1.24 in/s; at 1 ms
/// by 0.21 in, at 0.90 in/s.
constexpr double kLongestTickByHand_s = 0.002;
// A loop that comes too late again and again, but never stands still for as long as the guard waits, is ended by these
// counts alone. A virtual machine on a busy host needs 0.5 s in a row and 5 s in total.
constexpr double kLongestLate_s = 1.0;
constexpr double kMostLate_s = 10.0;

/// Judges a number of late or skipped ticks.
/// @param longest_s  of the loop that late, in ticks   @param usual  the default, which is always allowed
void judge_late(const config::RigConfig& rig, const char* key, int count, double longest_s, int usual,
                std::vector<std::string>& refusals) {
  const double period_s = rig.realtime.sample_period_s;
  const long most = std::max<long>(usual, std::lround(std::floor(longest_s / period_s * (1.0 + 1e-9))));
  if (count <= most) return;
  refusals.push_back(fmt::format(
      "realtime.{} = {}: a loop that is late for {:.3g} s would not end the run; set at most {}, {} is usual", key,
      count, count * period_s, most, usual));
}

}  // namespace

void judge_realtime(const config::RigConfig& rig, ArmingFindings& findings) {
  const config::RealtimeOptions& realtime = rig.realtime;
  if (realtime.sample_period_s > kLongestTick_s) {
    findings.refusals.push_back(
        fmt::format("realtime.sample_period_s = {:g} s: every check acts a tick late; set at most {:g} on a rig that "
                    "moves a machine",
                    realtime.sample_period_s, kLongestTick_s));
  }
  if (config::needs_following(rig) && realtime.sample_period_s > kLongestTickOfPulses_s) {
    findings.refusals.push_back(fmt::format(
        "realtime.sample_period_s = {:g} s: without [following] the valve is found by pulses, which are too "
        "long at this tick; set at most {:g} until the valve is measured",
        realtime.sample_period_s, kLongestTickOfPulses_s));
  } else if (rig.limits.following && !config::is_as_measured(rig) && realtime.sample_period_s > kLongestTickByHand_s) {
    findings.refusals.push_back(fmt::format(
        "realtime.sample_period_s = {:g} s: [following] is not as it was measured on this rig, and at this tick a dead "
        "sensor is found too late for numbers that may be wrong; set at most {:g}, or measure the valve (eha "
        "characterise)",
        realtime.sample_period_s, kLongestTickByHand_s));
  }
  if (const auto& stall_s = realtime.stall_limit_s; stall_s && *stall_s > kLongestStall_s) {
    findings.refusals.push_back(
        fmt::format("realtime.stall_limit_s = {:g} s: while the loop stands still the rod moves on by up to {:.2g} in "
                    "before the guard acts; set at most {:g}, or leave it out",
                    *stall_s, *stall_s * rig.limits.velocity_limit_in_per_s, kLongestStall_s));
  }
  const config::RealtimeOptions usual;
  judge_late(rig, "abort_consecutive_late", realtime.abort_consecutive_late, kLongestLate_s,
             usual.abort_consecutive_late, findings.refusals);
  judge_late(rig, "abort_total_late", realtime.abort_total_late, kMostLate_s, usual.abort_total_late,
             findings.refusals);
  if (realtime.priority > kHighestLoopPriority) {
    findings.warnings.push_back(fmt::format(
        "realtime.priority = {} is limited to {}: the guard runs at {} and must be able to preempt the loop; "
        "set at most {}",
        realtime.priority, kHighestLoopPriority, kGuardPriority, kHighestLoopPriority));
  }
}

}  // namespace eha
