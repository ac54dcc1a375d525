// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "hal/rig.hpp"

namespace eha::hal {

/// Kinds of injected faults.
enum class FaultKind {
  read_timed_out,     ///< read() returns timed_out
  read_io_error,      ///< read() returns io_error
  command_timed_out,  ///< command() returns timed_out, nothing is written
  command_io_error,   ///< command() returns io_error, nothing is written
  removed,            ///< every call returns removed from then on, make_safe() too
  not_finite,         ///< the displacement is NaN
  stuck_sensor,       ///< the reading stays at the last good one
  rail,               ///< the converter reads all ones, as a dead card does
  spike,              ///< `amount` [in] is added to the displacement
  slow_read,          ///< read() takes `amount` [s] longer
  slow_command,       ///< command() takes `amount` [s] longer
  emergency_stop,     ///< the emergency-stop circuit is open
};

/// An injected fault and its ticks. Tick k is the k-th read() since the rig was wrapped, from 0, with the command()
/// after it.
struct InjectedFault {
  FaultKind kind = FaultKind::read_timed_out;
  std::int64_t first_tick = 0;
  std::int64_t ticks = 1;  ///< for how many; kAlways for ever
  double amount = 0.0;     ///< spike [in], slow_read and slow_command [s]

  static constexpr std::int64_t kAlways = std::numeric_limits<std::int64_t>::max();
};

/// Lets time pass inside a call: a virtual clock's advance, or spin_for.
using Stall = std::function<void(std::int64_t duration_ns)>;

/// Busy-waits on CLOCK_MONOTONIC. Real-time safe.
void spin_for(std::int64_t duration_ns) noexcept;

/// Injects faults into the calls on the rig that it wraps, and otherwise passes them on. A read that fails still moves
/// the wrapped rig's time on: a plant moves under the command it holds.
class FaultRig final : public Rig {
 public:
  /// @param rig     wrapped, must outlive this
  /// @param stall   called for slow_read and slow_command; must not throw
  FaultRig(Rig& rig, std::vector<InjectedFault> faults, Stall stall = spin_for);

  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override;
  RigStatus read(std::int64_t elapsed_ns, RigReading& reading) noexcept override;
  RigStatus command(double command_V, AppliedCommand& applied) noexcept override;
  RigStatus set_enable(bool on) noexcept override;
  RigStatus make_safe() noexcept override;
  [[nodiscard]] std::string safe_snapshot() const override { return rig_.safe_snapshot(); }

 private:
  [[nodiscard]] const InjectedFault* active(FaultKind kind) const noexcept;

  Rig& rig_;
  std::vector<InjectedFault> faults_;
  Stall stall_;
  std::int64_t tick_ = -1;
  bool removed_ = false;
  RigReading last_good_;
};

}  // namespace eha::hal
