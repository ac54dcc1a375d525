// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/faults/fault_rig.hpp"

#include <time.h>

#include <algorithm>
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

/// What is left of a way of which the share is missed at the end of every piece.
double without_slips(double way, double piece, double share) noexcept {
  const double pieces = std::floor(std::abs(way) / piece);
  const double kept = (1.0 - share) * piece;
  return std::copysign(pieces * kept + std::min(std::abs(way) - pieces * piece, kept), way);
}

std::int64_t nanoseconds(double seconds) noexcept { return static_cast<std::int64_t>(std::llround(seconds * 1e9)); }

}  // namespace

void spin_for(std::int64_t duration_ns) noexcept {
  const std::int64_t end_ns = monotonic_ns() + duration_ns;
  while (monotonic_ns() < end_ns) {
  }
}

FaultRig::FaultRig(Rig& rig, std::vector<InjectedFault> faults, Stall stall, Conversion conversion)
    : rig_(rig), faults_(std::move(faults)), stall_(std::move(stall)), conversion_(std::move(conversion)) {}

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

  falsify(actual);
  if (active(FaultKind::rail)) {
    // The scale of the wrapped rig is not known here. All ones is full scale, and a rig reports the flag with it.
    actual.feedback_code = static_cast<std::uint32_t>(
        std::llround((capabilities().feedback_max_V - capabilities().feedback_min_V) / capabilities().feedback_lsb_V));
    actual.feedback_V = capabilities().feedback_max_V;
    actual.digital_inputs = std::numeric_limits<std::uint32_t>::max();
    actual.feedback_at_rail = true;
  }
  if (const InjectedFault* spike = active(FaultKind::spike)) actual.displacement_in += spike->amount;
  if (active(FaultKind::not_finite)) actual.displacement_in = std::numeric_limits<double>::quiet_NaN();
  if (active(FaultKind::emergency_stop)) actual.emergency_stop = true;
  if (active(FaultKind::contact_open)) actual.enable_contact = false;
  if (active(FaultKind::contact_closed)) actual.enable_contact = true;
  reading = actual;
  return RigStatus::ok;
}

void FaultRig::falsify(RigReading& reading) noexcept {
  const double lsb_V = capabilities().feedback_lsb_V;
  if (const InjectedFault* open = active(FaultKind::open_sensor)) {
    set_feedback(reading, open->amount + open->noise_LSB * lsb_V * noise_());
  } else if (active(FaultKind::reversed_sensor)) {
    set_feedback(reading, 2.0 * last_good_.feedback_V - reading.feedback_V);
  } else if (const InjectedFault* scaled = active(FaultKind::scaled_sensor)) {
    set_feedback(reading, last_good_.feedback_V + scaled->amount * (reading.feedback_V - last_good_.feedback_V));
  } else if (const InjectedFault* slips = active(FaultKind::slipping_sensor)) {
    const double way_V = reading.feedback_V - last_good_.feedback_V;
    set_feedback(reading, last_good_.feedback_V + without_slips(way_V, slips->way_V, slips->amount));
  } else if (const InjectedFault* lagging = active(FaultKind::lagging_sensor)) {
    lagged_V_ += (reading.feedback_V - lagged_V_) / lagging->amount;
    set_feedback(reading, lagged_V_);
  } else if (const InjectedFault* stuck = active(FaultKind::stuck_sensor)) {
    reading = last_good_;
    if (stuck->noise_LSB > 0.0) set_feedback(reading, last_good_.feedback_V + stuck->noise_LSB * lsb_V * noise_());
  } else {
    last_good_ = reading;
    lagged_V_ = reading.feedback_V;
  }
}

void FaultRig::set_feedback(RigReading& reading, double volts) const noexcept {
  const RigCapabilities& range = capabilities();
  const double last_code = std::round((range.feedback_max_V - range.feedback_min_V) / range.feedback_lsb_V);
  const double code = std::clamp(std::round((volts - range.feedback_min_V) / range.feedback_lsb_V), 0.0, last_code);
  reading.feedback_code = static_cast<std::uint32_t>(code);
  reading.feedback_V = range.feedback_min_V + code * range.feedback_lsb_V;
  reading.feedback_at_rail = reading.feedback_code == 0 || code >= last_code;
  reading.displacement_in = conversion_.offset_in + conversion_.scale_in_per_V * reading.feedback_V;
}

RigStatus FaultRig::command(double command_V, AppliedCommand& applied) noexcept {
  if (const InjectedFault* slow = active(FaultKind::slow_command)) stall_(nanoseconds(slow->amount));
  if (removed_) return RigStatus::removed;
  if (const InjectedFault* dead = active(FaultKind::output_timed_out)) {
    stall_(nanoseconds(dead->amount));
    return RigStatus::timed_out;
  }
  if (active(FaultKind::command_timed_out)) return RigStatus::timed_out;
  if (active(FaultKind::command_io_error)) return RigStatus::io_error;
  return rig_.command(command_V, applied);
}

RigStatus FaultRig::set_enable(bool on) noexcept { return removed_ ? RigStatus::removed : rig_.set_enable(on); }

RigStatus FaultRig::make_safe() noexcept {
  if (removed_) return RigStatus::removed;
  const InjectedFault* dead = active(FaultKind::output_timed_out);
  if (dead == nullptr) return rig_.make_safe();
  const RigStatus disabled = rig_.set_enable(false);
  stall_(nanoseconds(dead->amount));
  return disabled != RigStatus::ok ? disabled : RigStatus::timed_out;
}

}  // namespace eha::hal
