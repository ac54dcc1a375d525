// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/state_machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

namespace eha::acquisition {
namespace {

/// A machine brought to a state along the shortest way.
StateMachine at(State state) {
  const std::map<State, std::vector<State>> ways = {
      {State::faulted, {}},
      {State::idle, {State::idle}},
      {State::armed, {State::idle, State::armed}},
      {State::ramp_in, {State::idle, State::armed, State::ramp_in}},
      {State::running, {State::idle, State::armed, State::ramp_in, State::running}},
      {State::ramp_out, {State::idle, State::armed, State::ramp_in, State::running, State::ramp_out}},
      {State::safe_stop, {State::idle, State::safe_stop}}};
  StateMachine machine;
  for (const State step : ways.at(state)) machine.move_to(step);
  return machine;
}

TEST(StateMachine, HasExactlyTheArrowsOfItsDiagram) {
  using enum State;
  const std::map<State, std::vector<State>> arrows = {{faulted, {idle}},
                                                      {idle, {armed, safe_stop}},
                                                      {armed, {ramp_in, ramp_out, idle, safe_stop}},
                                                      {ramp_in, {running, ramp_out, safe_stop}},
                                                      {running, {ramp_out, safe_stop}},
                                                      {ramp_out, {idle, safe_stop}},
                                                      {safe_stop, {faulted}}};
  for (const auto& [from, targets] : arrows) {
    for (const State to : {faulted, idle, armed, ramp_in, running, ramp_out, safe_stop}) {
      StateMachine machine = at(from);
      ASSERT_EQ(machine.state(), from);
      const bool expected = std::find(targets.begin(), targets.end(), to) != targets.end();
      EXPECT_EQ(machine.move_to(to), expected) << to_text(from) << " to " << to_text(to);
      EXPECT_EQ(machine.state(), expected ? to : from);
    }
  }
}

TEST(StateMachine, BootsFaultedAndArmsOnlyAfterTheOperatorsReset) {
  StateMachine machine;
  EXPECT_EQ(machine.state(), State::faulted);
  EXPECT_FALSE(machine.arm());
  EXPECT_TRUE(machine.reset());
  EXPECT_FALSE(machine.reset());
  EXPECT_TRUE(machine.arm());
  EXPECT_TRUE(machine.disarm());
  EXPECT_EQ(machine.state(), State::idle);
}

}  // namespace
}  // namespace eha::acquisition
