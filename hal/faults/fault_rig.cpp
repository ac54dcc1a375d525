// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/faults/fault_rig.hpp"

#include <time.h>

#include <cmath>
#include <limits>
#include <utility>

namespace eha::hal {
namespace {

std::int64_t monotonic_ns() noexcept {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::int64_t nanoseconds(double seconds) noexcept { return static_cast<std::int64_t>(std::llround(seconds * 1e9)); }

}  // namespace

void spin_for(std::int64_t duration_ns) noexcept {
  const std::int64_t end_ns = monotonic_ns() + duration_ns;
  while (monotonic_ns() < end_ns) {
  }
}

FaultRig::FaultRig(Rig& rig, std::vector<InjectedFault> faults, Stall stall)
    : rig_(rig), faults_(std::move(faults)), stall_(std::move(stall)) {}

const RigCapabilities& FaultRig::capabilities() const noexcept { return rig_.capabilities(); }

const InjectedFault* FaultRig::active(FaultKind kind) const noexcept {
  for (const InjectedFault& fault : faults_) {
    if (fault.kind == kind && tick_ >= fault.first_tick && tick_ - fault.first_tick < fault.ticks) return &fault;
  }
  return nullptr;
}

RigStatus FaultRig::read(std::int64_t elapsed_ns, RigReading& reading) noexcept {
  ++tick_;
  removed_ = removed_ || active(FaultKind::removed) != nullptr;
  RigReading actual;
  const RigStatus status = rig_.read(elapsed_ns, actual);
  if (const InjectedFault* slow = active(FaultKind::slow_read)) stall_(nanoseconds(slow->amount));
  if (removed_) return RigStatus::removed;
  if (active(FaultKind::read_timed_out)) return RigStatus::timed_out;
  if (active(FaultKind::read_io_error)) return RigStatus::io_error;
  if (status != RigStatus::ok) return status;

  if (active(FaultKind::stuck_sensor)) {
    actual = last_good_;
  } else {
    last_good_ = actual;
  }
  if (active(FaultKind::rail)) {
    // The scale of the wrapped rig is not known here; all ones is full scale, and the flag is what a rig reports with
    // it.
    actual.feedback_code = static_cast<std::uint32_t>(
        std::llround((capabilities().feedback_max_V - capabilities().feedback_min_V) / capabilities().feedback_lsb_V));
    actual.feedback_V = capabilities().feedback_max_V;
    actual.digital_inputs = std::numeric_limits<std::uint32_t>::max();
    actual.feedback_at_rail = true;
  }
  if (const InjectedFault* spike = active(FaultKind::spike)) actual.displacement_in += spike->amount;
  if (active(FaultKind::not_finite)) actual.displacement_in = std::numeric_limits<double>::quiet_NaN();
  if (active(FaultKind::emergency_stop)) actual.emergency_stop = true;
  reading = actual;
  return RigStatus::ok;
}

RigStatus FaultRig::command(double command_V, AppliedCommand& applied) noexcept {
  if (const InjectedFault* slow = active(FaultKind::slow_command)) stall_(nanoseconds(slow->amount));
  if (removed_) return RigStatus::removed;
  if (active(FaultKind::command_timed_out)) return RigStatus::timed_out;
  if (active(FaultKind::command_io_error)) return RigStatus::io_error;
  return rig_.command(command_V, applied);
}

RigStatus FaultRig::set_enable(bool on) noexcept { return removed_ ? RigStatus::removed : rig_.set_enable(on); }

RigStatus FaultRig::make_safe() noexcept { return removed_ ? RigStatus::removed : rig_.make_safe(); }

}  // namespace eha::hal
