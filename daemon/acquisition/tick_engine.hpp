// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "config/rig_config.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/command_chain.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/acquisition/deadline_monitor.hpp"
#include "daemon/acquisition/earlier_runs.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "daemon/acquisition/limit_monitor.hpp"
#include "daemon/acquisition/run_report.hpp"
#include "daemon/acquisition/slip_monitor.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/acquisition/tick_record.hpp"
#include "hal/rig.hpp"

namespace eha::acquisition {

/// Inputs of one tick, from the loop.
struct TickInputs {
  std::uint32_t sequence = 0;
  std::int64_t scheduled_ns = 0;   ///< from the run's first tick [ns]
  std::int64_t woken_ns = 0;       ///< on the engine's clock [ns]
  std::int64_t lateness_ns = 0;    ///< 0 up to a period [ns]
  std::uint32_t skipped = 0;       ///< grid ticks lost just before this one
  int stops = 0;                   ///< stop requests so far
  bool sink_failing = false;       ///< records can no longer be kept, or will soon be lost
  std::int64_t suspended_ns = 0;   ///< time in which the machine was suspended since the run began [ns]
  bool guard_has_tripped = false;  ///< the guard found the loop stalled and switched the hydraulics off
  /// Read again just before each write: a fatal-signal handler may have taken the outputs since the tick began.
  const StopRequest* stop = nullptr;
};

/// Does the work of one tick: read, check, decide, command, record. The loop decides its time.
///
/// armed (100 ms): the safe voltage is written, then the enable line goes on, and the velocity estimate fills.
/// ramp_in: from the safe voltage to the source's row 0 under the slew limit, for as long as the source is preparing.
/// running: the source's rows until they or the source are over; the row follows the grid, so a skipped tick does not
/// shift the excitation. ramp_out: back to the safe voltage under the slew limit, then make_safe() and idle; on the
/// normal end, a stop, or a failing sink. safe_stop: on any fault or a second stop: the enable line off, the safe
/// voltage (left out where this tick's write timed out) and make_safe() in the same tick, make_safe() again each tick
/// until the device confirms (20 times), then faulted. A reading beyond 80 % of a travel or velocity limit is flagged.
/// If the rig has an auxiliary contact, staying open longer than the rig allows while the enable line is on is a fault.
/// A single time-out that returns within a tick is held and flagged. Time-outs in three ticks in a row, any other
/// failure, and any failure longer than a tick are faults. Real-time safe. Not thread-safe.
class TickEngine {
 public:
  /// Arguments are checked by run(). The rig, the machine, the source and the clock must outlive the engine.
  /// @param earlier  the runs before on this rig
  TickEngine(hal::Rig& rig, StateMachine& machine, CommandSource& source, const config::RigLimits& limits,
             const config::RealtimeOptions& realtime, LatePolicy late_policy, Clock& clock,
             const EarlierRuns& earlier = {}) noexcept;

  TickRecord tick(const TickInputs& inputs) noexcept;

  /// Records the row of a tick that never ran.
  TickRecord skipped_row(std::uint32_t sequence, std::int64_t scheduled_ns) noexcept;

  [[nodiscard]] bool finished() const noexcept { return finished_; }
  [[nodiscard]] bool interrupted() const noexcept { return interrupted_; }
  [[nodiscard]] bool sink_failed() const noexcept { return sink_failed_; }
  [[nodiscard]] bool safe_confirmed() const noexcept { return safe_confirmed_; }
  [[nodiscard]] const FaultReport& fault() const noexcept { return fault_; }
  /// What the next run begins with; no missing motion after a fault that sends somebody to the sensor or the valve.
  [[nodiscard]] EarlierRuns left() const noexcept {
    // What slipped stays until a ruler has shown where the rod is.
    const double slipped_in = fault_.fault == Fault::sensor_slip ? 0.0 : slip_monitor_.slipped_in();
    if (names_motion(fault_.fault)) return {{}, slipped_in, {}};
    return {following_monitor_.left_in(), slipped_in, source_.lacking() != nullptr ? *source_.lacking() : lacking_};
  }
  /// First running tick, from the run's first tick [ns]; 0 before it.
  [[nodiscard]] std::int64_t experiment_ns() const noexcept {
    return static_cast<std::int64_t>(first_row_) * period_ns_;
  }
  [[nodiscard]] const LoopCounters& counters() const noexcept { return counters_; }
  [[nodiscard]] double velocity_in_per_s() const noexcept { return limits_monitor_.velocity_in_per_s(); }
  /// Whether the auxiliary contact was closed at the last good reading.
  [[nodiscard]] bool enable_contact() const noexcept { return reading_.enable_contact; }
  /// Shares of the limits at the last reading; see LimitMonitor.
  [[nodiscard]] double travel_share() const noexcept { return limits_monitor_.travel_share(); }
  [[nodiscard]] double velocity_share() const noexcept { return limits_monitor_.velocity_share(); }
  /// Greatest values of the run.
  [[nodiscard]] const Margin& travel() const noexcept { return travel_; }
  [[nodiscard]] const Margin& velocity() const noexcept { return velocity_; }
  /// The greatest reading less the least [in].
  [[nodiscard]] double moved_in() const noexcept { return std::max(0.0, highest_in_ - lowest_in_); }
  [[nodiscard]] std::uint32_t experiment_rows() const noexcept { return rows_; }
  /// Returns the number of completed rows of the experiment, for progress.
  [[nodiscard]] std::uint32_t rows_played(std::uint32_t sequence) const noexcept;

 private:
  void sample(const TickInputs& inputs, TickRecord& row) noexcept;
  void note_margins(TickRecord& row) noexcept;
  [[nodiscard]] Breach check_slip(std::int64_t begun_ns, double earlier_speed_in_per_s) noexcept;
  [[nodiscard]] Breach check_contact(const hal::RigReading& reading) noexcept;
  void decide(const TickInputs& inputs) noexcept;
  void drive(const TickInputs& inputs, TickRecord& row) noexcept;
  void drive_safe(TickRecord& row) noexcept;
  void enable() noexcept;
  void finish_ramp_out() noexcept;
  [[nodiscard]] double requested_V(std::uint32_t sequence) noexcept;
  [[nodiscard]] bool note_call(hal::RigStatus status, std::int64_t begun_ns, Fault refusal) noexcept;
  void trip(Fault fault, double value = 0.0, double limit = 0.0, hal::RigStatus status = hal::RigStatus::ok) noexcept;
  [[nodiscard]] bool in_progress() const noexcept;

  hal::Rig& rig_;
  StateMachine& machine_;
  CommandSource& source_;
  std::uint32_t rows_;
  std::uint32_t rows_per_repetition_;
  double safe_V_;
  std::int64_t period_ns_;
  std::uint32_t armed_ticks_wanted_;
  Clock& clock_;
  CommandChain chain_;
  LimitMonitor limits_monitor_;
  FollowingMonitor following_monitor_;
  SlipMonitor slip_monitor_;
  LackingWay lacking_;  ///< of the runs before
  DeadlineMonitor deadlines_;

  hal::RigReading reading_;      ///< the last good one
  hal::AppliedCommand applied_;  ///< voltage on the output
  hal::AppliedCommand safe_applied_;
  FaultReport fault_;
  LoopCounters counters_;
  Margin travel_;
  Margin velocity_;
  double lowest_in_ = std::numeric_limits<double>::infinity();
  double highest_in_ = -std::numeric_limits<double>::infinity();
  std::int64_t contact_time_ns_ = 0;    ///< time that the auxiliary contact may be open while enabled; 0: there is none
  std::int64_t contact_closed_ns_ = 0;  ///< time at which it was last seen closed, or the enable line went on
  std::int64_t now_ns_ = 0;             ///< scheduled time of the present tick
  std::int64_t read_for_ns_ = 0;        ///< scheduled time of the last good reading
  std::int64_t read_from_ns_ = 0;       ///< when its call began, on the engine's clock
  std::uint32_t first_row_ = 0;         ///< sequence of the first running tick
  std::uint32_t armed_ticks_ = 0;
  int timeouts_in_a_row_ = 0;
  int safe_attempts_ = 0;
  bool timed_out_ = false;  ///< in the present tick
  bool has_reading_ = false;
  bool enabled_ = false;
  bool ramp_reached_ = false;
  bool interrupted_ = false;
  bool sink_failed_ = false;
  bool safe_confirmed_ = false;
  bool finished_ = false;
};

}  // namespace eha::acquisition
