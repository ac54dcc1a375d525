// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/tick_engine.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "daemon/acquisition/slip_limit.hpp"

namespace eha::acquisition {
namespace {

constexpr double kArmed_s = 0.1;
constexpr int kTolerableTimeouts = 2;
constexpr int kSafeAttempts = 20;
constexpr std::int64_t kShortestSuspend_ns = 10'000'000;  // the count never exceeds the truth: see Loop::play

template <typename Integer>
Integer saturated(std::int64_t value) noexcept {
  return static_cast<Integer>(
      std::clamp<std::int64_t>(value, std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max()));
}

bool outputs_taken(const TickInputs& inputs) noexcept { return inputs.stop != nullptr && inputs.stop->outputs_taken(); }

void raise_flag(TickRecord& row, TickFlag flag) noexcept { row.flags = static_cast<std::uint16_t>(row.flags | flag); }

}  // namespace

TickEngine::TickEngine(hal::Rig& rig, StateMachine& machine, CommandSource& source, const config::RigLimits& limits,
                       const config::RealtimeOptions& realtime, LatePolicy late_policy, Clock& clock,
                       const EarlierRuns& earlier) noexcept
    : rig_(rig),
      machine_(machine),
      source_(source),
      rows_(source.rows()),
      rows_per_repetition_(source.rows_per_repetition()),
      safe_V_(limits.safe_V),
      period_ns_(std::llround(realtime.sample_period_s * 1e9)),
      armed_ticks_wanted_(static_cast<std::uint32_t>(std::ceil(kArmed_s / realtime.sample_period_s))),
      clock_(clock),
      chain_(limits, realtime.sample_period_s),
      limits_monitor_(limits, realtime.sample_period_s),
      following_monitor_(following_rule(limits), earlier.missing_in),
      slip_monitor_(limits.velocity_limit_in_per_s, earlier.slipped_in),
      deadlines_(realtime, late_policy) {
  const hal::RigCapabilities& abilities = rig.capabilities();
  if (source.brings_back()) limits_monitor_.allow_way_back();
  source.go_on_from(earlier.lacking);
  lacking_ = earlier.lacking;
  if (abilities.has_enable_contact) contact_time_ns_ = std::llround(abilities.enable_contact_time_s * 1e9);
  applied_.applied_V = safe_V_;
  safe_applied_.applied_V = safe_V_;
}

TickRecord TickEngine::tick(const TickInputs& inputs) noexcept {
  TickRecord row{};
  now_ns_ = inputs.scheduled_ns;
  timed_out_ = false;
  row.scheduled_ns = inputs.scheduled_ns;
  row.sequence = inputs.sequence;
  row.lateness_ns = saturated<std::int32_t>(inputs.lateness_ns);
  ++counters_.ticks;
  counters_.skipped += inputs.skipped;
  if (machine_.state() == State::running) {
    // Counted here, not in skipped_row(), which the loop does not call beyond some number.
    const std::int64_t played = inputs.sequence - first_row_;
    const std::int64_t missed = std::min<std::int64_t>(played, rows_) - (played - inputs.skipped);
    const auto lost = static_cast<std::uint64_t>(std::max<std::int64_t>(0, missed));
    counters_.experiment_rows += lost;
    counters_.skipped_rows += lost;
  }

  const bool is_late = inputs.lateness_ns > period_ns_ / 2;
  if (is_late) {
    raise_flag(row, kLate);
    ++counters_.late;
  }
  const Breach missed = deadlines_.note(inputs.skipped, is_late);
  if (machine_.state() == State::safe_stop) {
    // The device may no longer answer: the remaining calls only make it safe.
    raise_flag(row, kFeedbackHeld);
  } else {
    if (inputs.guard_has_tripped) trip(Fault::loop_stalled, static_cast<double>(inputs.skipped * period_ns_) * 1e-9);
    if (inputs.suspended_ns > kShortestSuspend_ns) {
      trip(Fault::suspended, static_cast<double>(inputs.suspended_ns) * 1e-9);
    }
    if (missed.fault != Fault::none) trip(missed.fault, missed.value, missed.limit);
    sample(inputs, row);
    decide(inputs);
  }
  row.displacement_in = has_reading_ ? reading_.displacement_in : std::numeric_limits<double>::quiet_NaN();
  row.feedback_code = reading_.feedback_code;
  row.digital_inputs = reading_.digital_inputs;

  drive(inputs, row);
  timeouts_in_a_row_ = timed_out_ ? timeouts_in_a_row_ : 0;

  // A fault of this tick's write is recorded in this tick's row, which then is no row of the experiment.
  row.state = machine_.state() == State::faulted || machine_.state() == State::safe_stop ? State::safe_stop : row.state;
  row.fault = fault_.fault;
  row.applied_V = applied_.applied_V;
  row.command_code = applied_.code;
  if (row.state == State::running) {
    row.repetition = static_cast<std::uint16_t>((inputs.sequence - first_row_) / rows_per_repetition_ + 1);
    ++counters_.experiment_rows;
  }
  row.execution_ns = saturated<std::uint32_t>(clock_.now_ns() - inputs.woken_ns);
  return row;
}

TickRecord TickEngine::skipped_row(std::uint32_t sequence, std::int64_t scheduled_ns) noexcept {
  TickRecord row{};
  row.scheduled_ns = scheduled_ns;
  row.sequence = sequence;
  row.flags = kSkipped | kFeedbackHeld | kCommandHeld;
  row.state = machine_.state();
  row.fault = fault_.fault;
  row.feedback_code = reading_.feedback_code;
  row.digital_inputs = reading_.digital_inputs;
  row.displacement_in = std::numeric_limits<double>::quiet_NaN();
  row.requested_V = safe_V_;
  if (row.state == State::running) {
    const std::uint32_t index = sequence - first_row_;
    if (index < rows_) {
      row.repetition = static_cast<std::uint16_t>(index / rows_per_repetition_ + 1);
      row.requested_V = requested_V(sequence);
    } else {
      row.state = State::ramp_out;
    }
  } else if (row.state == State::ramp_in) {
    row.requested_V = requested_V(sequence);  // a source counts its time by the ticks
  }
  row.applied_V = applied_.applied_V;
  row.command_code = applied_.code;
  return row;
}

std::uint32_t TickEngine::rows_played(std::uint32_t sequence) const noexcept {
  switch (machine_.state()) {
    case State::running:
      return std::min(rows_, sequence - first_row_ + 1);
    case State::armed:
    case State::ramp_in:
      return 0;
    default:
      return static_cast<std::uint32_t>(std::min<std::uint64_t>(counters_.experiment_rows, rows_));
  }
}

void TickEngine::sample(const TickInputs& inputs, TickRecord& row) noexcept {
  hal::RigReading reading;
  const std::int64_t begun_ns = clock_.now_ns();
  row.read_status = rig_.read(inputs.scheduled_ns, reading);
  if (!note_call(row.read_status, begun_ns, Fault::read_failed)) {
    raise_flag(row, kFeedbackHeld);
    return;
  }
  reading_ = reading;
  has_reading_ = true;
  if (reading.feedback_at_rail) raise_flag(row, kFeedbackRail);
  if (reading.emergency_stop) raise_flag(row, kEmergencyStop);
  const double earlier_speed_in_per_s = limits_monitor_.velocity_in_per_s();
  Breach breach = limits_monitor_.check(inputs.scheduled_ns, reading, applied_.applied_V);
  if (breach.fault == Fault::none) {
    breach = following_monitor_.check(inputs.scheduled_ns, reading.displacement_in, applied_.applied_V);
  }
  // Whatever else ends the run: what slipped in this tick is not forgotten.
  const bool shows_place = !reading.feedback_at_rail && std::isfinite(reading.displacement_in);
  const Breach slip = shows_place ? check_slip(begun_ns, earlier_speed_in_per_s) : Breach{};
  if (breach.fault == Fault::none) breach = slip;
  if (breach.fault == Fault::none) breach = check_contact(reading);
  note_margins(row);
  if (breach.fault != Fault::none) trip(breach.fault, breach.value, breach.limit);
}

void TickEngine::note_margins(TickRecord& row) noexcept {
  const auto note = [&](double share, Margin& greatest, TickFlag flag) {
    if (share > kWarningShare) raise_flag(row, flag);
    if (share > greatest.share) greatest = {share, now_ns_};
  };
  note(limits_monitor_.travel_share(), travel_, kNearTravel);
  note(limits_monitor_.velocity_share(), velocity_, kNearVelocity);
  if (reading_.feedback_at_rail || !std::isfinite(reading_.displacement_in)) return;
  lowest_in_ = std::min(lowest_in_, reading_.displacement_in);
  highest_in_ = std::max(highest_in_, reading_.displacement_in);
}

Breach TickEngine::check_slip(std::int64_t begun_ns, double earlier_speed_in_per_s) noexcept {
  const std::int64_t since_ns = now_ns_ - read_for_ns_;
  const std::int64_t longest_ns = std::max(since_ns, clock_.now_ns() - read_from_ns_);
  read_for_ns_ = now_ns_;
  read_from_ns_ = begun_ns;
  return slip_monitor_.check(reading_.displacement_in, earlier_speed_in_per_s,
                             static_cast<double>(since_ns) * kSecondsPerNanosecond,
                             static_cast<double>(longest_ns) * kSecondsPerNanosecond);
}

Breach TickEngine::check_contact(const hal::RigReading& reading) noexcept {
  if (!enabled_ || contact_time_ns_ == 0) return {};
  if (reading.enable_contact) {
    contact_closed_ns_ = now_ns_;
    return {};
  }
  const std::int64_t open_ns = now_ns_ - contact_closed_ns_;
  if (open_ns <= contact_time_ns_) return {};
  return {Fault::enable_contact, static_cast<double>(open_ns) * 1e-9, static_cast<double>(contact_time_ns_) * 1e-9};
}

void TickEngine::decide(const TickInputs& inputs) noexcept {
  if (inputs.sink_failing) sink_failed_ = true;
  if (inputs.stops >= 2) {
    interrupted_ = true;
    trip(Fault::second_stop, static_cast<double>(inputs.stops), 1.0);
    return;
  }
  if ((inputs.stops == 1 || inputs.sink_failing) && in_progress()) {
    interrupted_ = inputs.stops == 1;
    machine_.move_to(State::ramp_out);
    return;
  }
  const bool is_played = machine_.state() == State::ramp_in || machine_.state() == State::running;
  if (const Breach breach = is_played ? source_.breach() : Breach{}; breach.fault != Fault::none) {
    trip(breach.fault, breach.value, breach.limit);
    fault_.driven_V = breach.driven_V;
    fault_.driven_s = breach.driven_s;
    return;
  }
  switch (machine_.state()) {
    case State::armed:
      if (enabled_ && has_reading_ && ++armed_ticks_ >= armed_ticks_wanted_) machine_.move_to(State::ramp_in);
      break;
    case State::ramp_in:
      if (ramp_reached_ && source_.stage() != CommandSource::Stage::preparing && machine_.move_to(State::running)) {
        first_row_ = inputs.sequence;
      }
      break;
    case State::running:
      if (inputs.sequence - first_row_ >= rows_ || source_.stage() == CommandSource::Stage::over) {
        machine_.move_to(State::ramp_out);
      }
      break;
    default:
      break;
  }
}

void TickEngine::drive(const TickInputs& inputs, TickRecord& row) noexcept {
  row.state = machine_.state();
  row.requested_V = requested_V(inputs.sequence);
  if (outputs_taken(inputs)) {
    raise_flag(row, kCommandHeld);
    machine_.move_to(State::safe_stop);
    machine_.move_to(State::faulted);
    finished_ = true;
    return;
  }
  if (machine_.state() == State::safe_stop) {
    drive_safe(row);
    return;
  }
  if (!std::isfinite(row.requested_V)) {
    trip(Fault::command_not_finite, row.requested_V);
    drive_safe(row);
    return;
  }
  const CommandChain::Step step = chain_.plan(row.requested_V);
  if (step.clamped) raise_flag(row, kClamped);
  if (step.slew_limited) raise_flag(row, kSlewLimited);
  if (row.state == State::running) {
    counters_.clamped += step.clamped ? 1 : 0;
    counters_.slew_limited += step.slew_limited ? 1 : 0;
  }
  hal::AppliedCommand applied;
  const std::int64_t begun_ns = clock_.now_ns();
  row.command_status = rig_.command(step.command_V, applied);
  if (note_call(row.command_status, begun_ns, Fault::command_failed)) {
    applied_ = applied;
    chain_.accept(step.command_V);
    ramp_reached_ = !step.slew_limited;
    if (row.state == State::armed && !enabled_ && !outputs_taken(inputs)) enable();
    if (row.state == State::ramp_out && ramp_reached_) finish_ramp_out();
  } else {
    raise_flag(row, kCommandHeld);
    ramp_reached_ = false;
  }
  if (machine_.state() == State::safe_stop) drive_safe(row);
}

void TickEngine::drive_safe(TickRecord& row) noexcept {
  row.requested_V = safe_V_;
  // Ignores the result: make_safe() switches it off again and confirms it.
  static_cast<void>(rig_.set_enable(false));
  // command() returns the code of the safe voltage, but an output that has just timed out would cause another time-out;
  // make_safe() is the last write.
  bool is_written = false;
  if (safe_attempts_ == 0 && row.command_status != hal::RigStatus::timed_out) {
    hal::AppliedCommand applied;
    const hal::RigStatus command_status = rig_.command(safe_V_, applied);
    is_written = command_status == hal::RigStatus::ok;
    if (is_written) applied_ = applied;
    if (row.command_status == hal::RigStatus::ok) row.command_status = command_status;
  }
  const hal::RigStatus safe_status = rig_.make_safe();
  safe_confirmed_ = safe_status == hal::RigStatus::ok;
  if (!is_written && safe_confirmed_) applied_ = safe_applied_;
  if (!is_written && !safe_confirmed_) raise_flag(row, kCommandHeld);
  if (row.command_status == hal::RigStatus::ok) row.command_status = safe_status;
  if (safe_confirmed_ || ++safe_attempts_ >= kSafeAttempts) {
    machine_.move_to(State::faulted);
    finished_ = true;
  }
}

void TickEngine::enable() noexcept {
  safe_applied_ = applied_;
  const std::int64_t begun_ns = clock_.now_ns();
  enabled_ = note_call(rig_.set_enable(true), begun_ns, Fault::command_failed);
  contact_closed_ns_ = now_ns_;
  if (enabled_) following_monitor_.begin(now_ns_);
}

void TickEngine::finish_ramp_out() noexcept {
  const hal::RigStatus status = rig_.make_safe();
  if (status != hal::RigStatus::ok) {
    trip(Fault::safe_write_failed, 0.0, 0.0, status);
    return;
  }
  safe_confirmed_ = true;
  machine_.move_to(State::idle);
  finished_ = true;
}

double TickEngine::requested_V(std::uint32_t sequence) noexcept {
  switch (machine_.state()) {
    case State::ramp_in:
      return source_.voltage_V(0, reading_);
    case State::running:
      return source_.voltage_V(sequence - first_row_, reading_);
    default:
      return safe_V_;
  }
}

bool TickEngine::note_call(hal::RigStatus status, std::int64_t begun_ns, Fault refusal) noexcept {
  if (status == hal::RigStatus::ok) return true;
  const std::int64_t duration_ns = clock_.now_ns() - begun_ns;
  if (status == hal::RigStatus::removed) {
    trip(Fault::device_removed, 0.0, 0.0, status);
  } else if (duration_ns > period_ns_) {
    trip(Fault::call_overran, static_cast<double>(duration_ns) * 1e-9, static_cast<double>(period_ns_) * 1e-9, status);
  } else if (status == hal::RigStatus::timed_out) {
    ++counters_.timeouts;
    if (!timed_out_) ++timeouts_in_a_row_;
    timed_out_ = true;
    if (timeouts_in_a_row_ > kTolerableTimeouts) {
      trip(Fault::repeated_timeouts, static_cast<double>(timeouts_in_a_row_), kTolerableTimeouts, status);
    }
  } else if (status == hal::RigStatus::not_finite) {
    trip(Fault::command_not_finite, 0.0, 0.0, status);
  } else {
    trip(refusal, 0.0, 0.0, status);
  }
  return false;
}

void TickEngine::trip(Fault fault, double value, double limit, hal::RigStatus status) noexcept {
  if (fault_.fault == Fault::none) {
    const bool has_jumped = limits_monitor_.has_jumped() || std::abs(slip_monitor_.slipped_in()) > kMostSlip_in;
    fault_ = {fault, status, now_ns_, value, limit, has_jumped};
  }
  machine_.move_to(State::safe_stop);
}

bool TickEngine::in_progress() const noexcept {
  const State state = machine_.state();
  return state == State::armed || state == State::ramp_in || state == State::running;
}

}  // namespace eha::acquisition
