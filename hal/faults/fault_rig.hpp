// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include "hal/conversion.hpp"
#include "hal/rig.hpp"
#include "hal/sim/normal_noise.hpp"

namespace eha::hal {

/// Kinds of injected faults.
enum class FaultKind {
  read_timed_out,     ///< read() returns timed_out
  read_io_error,      ///< read() returns io_error
  command_timed_out,  ///< command() returns timed_out, nothing is written
  command_io_error,   ///< command() returns io_error, nothing is written
  output_timed_out,   ///< every write to the output takes `amount` [s] and times out: command()'s and make_safe()'s
  removed,            ///< every call returns removed from then on, make_safe() too
  not_finite,         ///< the displacement is NaN
  stuck_sensor,       ///< the reading stays at the last good one, with noise of `noise_LSB`
  open_sensor,        ///< the sensor's input reads `amount` [V], with noise of `noise_LSB`
  reversed_sensor,    ///< the sensor's voltage moves in the wrong direction from the last good reading
  scaled_sensor,      ///< the sensor's voltage moves by `amount` times the right change from the last good reading
  slipping_sensor,    ///< the sensor's voltage misses the share `amount` of every `way_V` that it should move: in jerks
  lagging_sensor,     ///< the sensor's voltage passes a first-order lag of `amount` ticks
  rail,               ///< the converter reads all ones, as a dead card does
  spike,              ///< `amount` [in] is added to the displacement
  slow_read,          ///< read() takes `amount` [s] longer
  slow_command,       ///< command() takes `amount` [s] longer
  emergency_stop,     ///< the emergency-stop circuit is open
  contact_open,       ///< the enable contactor's auxiliary contact reads open: not pulled in, or dropped out
  contact_closed,     ///< the contact reads closed: the contactor is welded
};

/// An injected fault and its ticks. Tick k is the k-th read() since the rig was wrapped, counted from 0, with the
/// command() after it.
struct InjectedFault {
  FaultKind kind = FaultKind::read_timed_out;
  std::int64_t first_tick = 0;
  std::int64_t ticks = 1;  ///< number of faulty ticks; kAlways for ever
  double amount = 0.0;     ///< spike [in]; slow_read, slow_command and output_timed_out [s]; open_sensor [V];
                           ///< scaled_sensor factor; slipping_sensor share; lagging_sensor [ticks]
  double noise_LSB = 0.0;  ///< standard deviation of the noise of stuck_sensor and open_sensor, converter steps
  double way_V = 1.0;      ///< of slipping_sensor

  static constexpr std::int64_t kAlways = std::numeric_limits<std::int64_t>::max();
};

/// Passes time inside a call: advances a virtual clock, or calls spin_for.
using Stall = std::function<void(std::int64_t duration_ns)>;

/// Busy-waits on CLOCK_MONOTONIC. Real-time safe.
void spin_for(std::int64_t duration_ns) noexcept;

/// Injects faults into the calls on the wrapped rig, and otherwise passes them on. A failing read still advances the
/// wrapped rig's time: the plant moves under the command it holds.
class FaultRig final : public Rig {
 public:
  /// @param rig         wrapped, must outlive this
  /// @param stall       called for slow_read, slow_command and output_timed_out; must not throw
  /// @param conversion  of the wrapped rig; the faults of the sensor need it
  FaultRig(Rig& rig, std::vector<InjectedFault> faults, Stall stall = spin_for, Conversion conversion = {});

  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override;
  RigStatus read(std::int64_t elapsed_ns, RigReading& reading) noexcept override;
  RigStatus command(double command_V, AppliedCommand& applied) noexcept override;
  RigStatus set_enable(bool on) noexcept override;
  /// While the output times out, still switches the wrapped rig's enable line off, and keeps the voltage.
  RigStatus make_safe() noexcept override;
  [[nodiscard]] std::string safe_snapshot() const override { return rig_.safe_snapshot(); }

 private:
  [[nodiscard]] const InjectedFault* active(FaultKind kind) const noexcept;
  void falsify(RigReading& reading) noexcept;
  void set_feedback(RigReading& reading, double volts) const noexcept;

  Rig& rig_;
  std::vector<InjectedFault> faults_;
  Stall stall_;
  Conversion conversion_;
  NormalNoise noise_{1};
  std::int64_t tick_ = -1;
  bool removed_ = false;
  RigReading last_good_;
  double lagged_V_ = 0.0;
};

}  // namespace eha::hal
