// SPDX-License-Identifier: GPL-3.0-or-later
// The end of a run: the output counts as safe only once the device has confirmed it.
#include <gtest/gtest.h>

#include "core/error.hpp"
#include "daemon/acquisition/run.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

TEST(Run, TriesAgainUntilTheDeviceConfirmsThatItIsSafe) {
  FakeRig rig;
  rig.safe_failures = 5;
  Play play;
  play.stop.request();
  play.stop.request();
  play.on(rig);
  EXPECT_EQ(rig.safe_calls, 6);
  EXPECT_TRUE(play.report.safe_confirmed);
  EXPECT_TRUE(rig.is_safe());
  EXPECT_EQ(play.count(State::safe_stop), 6u);
}

TEST(Run, SaysLoudlyWhenTheOutputIsNotConfirmedSafe) {
  FakeRig rig;
  rig.safe_failures = 1000;
  Play play;
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::faulted);
  EXPECT_EQ(play.report.fault.fault, Fault::safe_write_failed);
  EXPECT_EQ(exit_code(play.report), ExitCode::device_unavailable);
  EXPECT_FALSE(play.report.safe_confirmed);
  EXPECT_NE(describe(play.report).find("NOT CONFIRMED SAFE"), std::string::npos);
}

TEST(Run, IsNotMerelyInterruptedWhenASecondStopLeavesTheOutputUnconfirmed) {
  FakeRig rig;
  rig.safe_failures = 1000;
  Play play;
  play.stop.request();
  play.stop.request();
  play.on(rig);
  EXPECT_EQ(play.report.outcome, Outcome::interrupted);
  EXPECT_FALSE(play.report.safe_confirmed);
  EXPECT_EQ(exit_code(play.report), ExitCode::device_unavailable);
}

}  // namespace
}  // namespace eha::acquisition
