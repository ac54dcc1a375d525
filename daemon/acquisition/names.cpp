// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace eha::acquisition {

std::string_view to_text(State state) noexcept {
  switch (state) {
    case State::faulted:
      return "faulted";
    case State::idle:
      return "idle";
    case State::armed:
      return "armed";
    case State::ramp_in:
      return "ramp_in";
    case State::running:
      return "running";
    case State::ramp_out:
      return "ramp_out";
    case State::safe_stop:
      return "safe_stop";
  }
  return "unknown";
}

std::string_view to_text(Fault fault) noexcept {
  switch (fault) {
    case Fault::none:
      return "none";
    case Fault::emergency_stop:
      return "emergency_stop";
    case Fault::travel_limit:
      return "travel_limit";
    case Fault::velocity_limit:
      return "velocity_limit";
    case Fault::feedback_rail:
      return "feedback_rail";
    case Fault::frozen_sensor:
      return "frozen_sensor";
    case Fault::feedback_not_finite:
      return "feedback_not_finite";
    case Fault::command_not_finite:
      return "command_not_finite";
    case Fault::repeated_timeouts:
      return "repeated_timeouts";
    case Fault::call_overran:
      return "call_overran";
    case Fault::read_failed:
      return "read_failed";
    case Fault::command_failed:
      return "command_failed";
    case Fault::device_removed:
      return "device_removed";
    case Fault::consecutive_late:
      return "consecutive_late";
    case Fault::total_late:
      return "total_late";
    case Fault::second_stop:
      return "second_stop";
    case Fault::safe_write_failed:
      return "safe_write_failed";
  }
  return "unknown";
}

std::string_view to_text(hal::RigStatus status) noexcept {
  switch (status) {
    case hal::RigStatus::ok:
      return "ok";
    case hal::RigStatus::timed_out:
      return "timed_out";
    case hal::RigStatus::io_error:
      return "io_error";
    case hal::RigStatus::busy:
      return "busy";
    case hal::RigStatus::locked:
      return "locked";
    case hal::RigStatus::removed:
      return "removed";
    case hal::RigStatus::not_finite:
      return "not_finite";
  }
  return "unknown";
}

std::string_view to_text(Outcome outcome) noexcept {
  switch (outcome) {
    case Outcome::completed:
      return "completed";
    case Outcome::interrupted:
      return "interrupted";
    case Outcome::faulted:
      return "faulted";
    case Outcome::deadline:
      return "deadline";
    case Outcome::write_failed:
      return "write_failed";
    case Outcome::recovered:
      return "recovered";
  }
  return "unknown";
}

}  // namespace eha::acquisition
