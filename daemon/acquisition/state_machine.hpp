// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/acquisition/tick_record.hpp"

namespace eha::acquisition {

/// The latched states of a rig: faulted -> idle -> armed -> ramp_in -> running -> ramp_out -> idle, and from each of
/// these safe_stop -> faulted. Starts faulted; only the operator's reset() leaves faulted.
/// Real-time safe. Not thread-safe: belongs to the supervisor between runs and to the loop during one.
class StateMachine {
 public:
  [[nodiscard]] State state() const noexcept { return state_; }

  /// Makes a transition if the diagram has it. @returns whether it has
  bool move_to(State next) noexcept;

  /// The operator's acknowledgement of a fault: faulted -> idle.
  bool reset() noexcept { return state_ == State::faulted && move_to(State::idle); }
  /// idle -> armed.
  bool arm() noexcept { return state_ == State::idle && move_to(State::armed); }
  /// armed -> idle.
  bool disarm() noexcept { return state_ == State::armed && move_to(State::idle); }

 private:
  State state_ = State::faulted;
};

}  // namespace eha::acquisition
