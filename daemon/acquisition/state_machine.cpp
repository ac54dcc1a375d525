// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/state_machine.hpp"

namespace eha::acquisition {
namespace {

bool has_arrow(State from, State to) noexcept {
  switch (from) {
    case State::faulted:
      return to == State::idle;
    case State::idle:
      return to == State::armed || to == State::safe_stop;
    case State::armed:
      return to == State::ramp_in || to == State::ramp_out || to == State::idle || to == State::safe_stop;
    case State::ramp_in:
      return to == State::running || to == State::ramp_out || to == State::safe_stop;
    case State::running:
      return to == State::ramp_out || to == State::safe_stop;
    case State::ramp_out:
      return to == State::idle || to == State::safe_stop;
    case State::safe_stop:
      return to == State::faulted;
  }
  return false;
}

}  // namespace

bool StateMachine::move_to(State next) noexcept {
  if (!has_arrow(state_, next)) return false;
  state_ = next;
  return true;
}

}  // namespace eha::acquisition
