// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/faults/fault_rig.hpp"

#include <gtest/gtest.h>
#include <time.h>

#include <cmath>

#include "hal/sim/sim_rig.hpp"

namespace eha::hal {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;

/// A moving simulated rig behind the given faults, and an untouched twin.
struct Pair {
  explicit Pair(
      std::vector<InjectedFault> faults, Stall stall = [](std::int64_t) {})
      : inner(open_rig(SimOptions(), 0.0)), twin(open_rig(SimOptions(), 0.0)), rig(*inner, std::move(faults), stall) {
    inner->set_enable(true);
    twin->set_enable(true);
  }

  struct Tick {
    RigStatus read_status;
    RigStatus command_status;
    RigReading reading;
    RigReading true_reading;
  };
  Tick tick(double command_V) {
    Tick t{};
    AppliedCommand applied;
    t.read_status = rig.read(elapsed_ns, t.reading);
    t.command_status = rig.command(command_V, applied);
    twin->read(elapsed_ns, t.true_reading);
    twin->command(command_V, applied);
    elapsed_ns += kTick_ns;
    return t;
  }

  std::unique_ptr<Rig> inner;
  std::unique_ptr<Rig> twin;
  FaultRig rig;
  std::int64_t elapsed_ns = 0;
};

TEST(FaultRig, PassesEverythingOnWhenNothingIsWrong) {
  Pair pair({});
  for (int k = 0; k < 50; ++k) {
    const auto t = pair.tick(3.0);
    ASSERT_EQ(t.read_status, RigStatus::ok);
    ASSERT_EQ(t.command_status, RigStatus::ok);
    ASSERT_EQ(t.reading.feedback_code, t.true_reading.feedback_code);
  }
  EXPECT_EQ(pair.rig.capabilities().backend, "sim");
}

TEST(FaultRig, FailsTheCallsOfTheGivenTicksAndNoOther) {
  const std::pair<FaultKind, RigStatus> reads[] = {{FaultKind::read_timed_out, RigStatus::timed_out},
                                                   {FaultKind::read_io_error, RigStatus::io_error}};
  for (const auto& [kind, status] : reads) {
    Pair pair({{kind, 3, 2}});
    for (int k = 0; k < 8; ++k) {
      const auto t = pair.tick(3.0);
      EXPECT_EQ(t.read_status, k == 3 || k == 4 ? status : RigStatus::ok) << k;
      EXPECT_EQ(t.command_status, RigStatus::ok);
      if (t.read_status == RigStatus::ok) {
        EXPECT_EQ(t.reading.feedback_code, t.true_reading.feedback_code);
      }
    }
  }
  const std::pair<FaultKind, RigStatus> commands[] = {{FaultKind::command_timed_out, RigStatus::timed_out},
                                                      {FaultKind::command_io_error, RigStatus::io_error}};
  for (const auto& [kind, status] : commands) {
    Pair pair({{kind, 3, 2}});
    for (int k = 0; k < 8; ++k) {
      const auto t = pair.tick(3.0);
      EXPECT_EQ(t.read_status, RigStatus::ok);
      EXPECT_EQ(t.command_status, k == 3 || k == 4 ? status : RigStatus::ok) << k;
    }
  }
}

TEST(FaultRig, LeavesTheCommandUnwrittenThatFailed) {
  Pair pair({{FaultKind::command_io_error, 0, InjectedFault::kAlways}});
  RigReading first;
  RigReading last;
  for (int k = 0; k < 2000; ++k) {
    const auto t = pair.tick(5.0);
    (k == 0 ? first : last) = t.reading;
  }
  RigReading held;
  const auto idle = open_rig(SimOptions(), 0.0);
  idle->set_enable(true);
  for (int k = 0; k < 2000; ++k) idle->read(k * kTick_ns, held);
  EXPECT_EQ(last.feedback_code, held.feedback_code) << "the plant saw 0 V all the time";
}

TEST(FaultRig, StaysRemovedOnceRemoved) {
  Pair pair({{FaultKind::removed, 2, 1}});
  for (int k = 0; k < 6; ++k) {
    const auto t = pair.tick(1.0);
    EXPECT_EQ(t.read_status, k < 2 ? RigStatus::ok : RigStatus::removed);
    EXPECT_EQ(t.command_status, k < 2 ? RigStatus::ok : RigStatus::removed);
  }
  EXPECT_EQ(pair.rig.set_enable(false), RigStatus::removed);
  EXPECT_EQ(pair.rig.make_safe(), RigStatus::removed);
}

TEST(FaultRig, FalsifiesTheReading) {
  Pair pair({{FaultKind::not_finite, 1},
             {FaultKind::spike, 2, 1, -0.75},
             {FaultKind::rail, 3},
             {FaultKind::emergency_stop, 4},
             {FaultKind::stuck_sensor, 100, 300}});
  Pair::Tick t[6];
  for (auto& each : t) each = pair.tick(4.0);
  EXPECT_TRUE(std::isnan(t[1].reading.displacement_in));
  EXPECT_DOUBLE_EQ(t[2].reading.displacement_in, t[2].true_reading.displacement_in - 0.75);
  EXPECT_TRUE(t[3].reading.feedback_at_rail);
  EXPECT_EQ(t[3].reading.feedback_code, 65535U);
  EXPECT_DOUBLE_EQ(t[3].reading.feedback_V, 10.0);
  EXPECT_TRUE(t[4].reading.emergency_stop);
  EXPECT_FALSE(t[5].reading.emergency_stop || t[5].reading.feedback_at_rail);
  EXPECT_EQ(t[5].reading.feedback_code, t[5].true_reading.feedback_code);

  std::uint32_t stuck = 0;
  for (int k = 6; k < 402; ++k) {
    const auto each = pair.tick(4.0);
    if (k == 99) stuck = each.reading.feedback_code;
    if (k >= 100) {
      ASSERT_EQ(each.reading.feedback_code, k < 400 ? stuck : each.true_reading.feedback_code) << k;
    }
  }
}

TEST(FaultRig, LetsTimePassInsideSlowCalls) {
  std::int64_t stalled_ns = 0;
  Pair pair({{FaultKind::slow_read, 1, 2, 0.0005}, {FaultKind::slow_command, 2, 1, 0.25}},
            [&](std::int64_t duration_ns) { stalled_ns += duration_ns; });
  pair.tick(1.0);
  EXPECT_EQ(stalled_ns, 0);
  pair.tick(1.0);
  EXPECT_EQ(stalled_ns, 500'000);
  EXPECT_EQ(pair.tick(1.0).command_status, RigStatus::ok);
  EXPECT_EQ(stalled_ns, 251'000'000);
}

TEST(FaultRig, SwitchesTheEnableLineOffWhileTheOutputTimesOut) {
  std::int64_t stalled_ns = 0;
  Pair pair({{FaultKind::output_timed_out, 1, InjectedFault::kAlways, 1.0}},
            [&](std::int64_t duration_ns) { stalled_ns += duration_ns; });
  EXPECT_EQ(pair.tick(5.0).command_status, RigStatus::ok);
  EXPECT_EQ(pair.tick(5.0).command_status, RigStatus::timed_out);
  EXPECT_EQ(pair.rig.make_safe(), RigStatus::timed_out);
  EXPECT_EQ(stalled_ns, 2'000'000'000);
  RigReading held;
  for (int k = 0; k < 500; ++k) held = pair.tick(5.0).reading;
  RigReading end;
  for (int k = 0; k < 500; ++k) end = pair.tick(5.0).reading;
  EXPECT_NEAR(end.displacement_in, held.displacement_in, 0.01) << "the hydraulics are off, so that 5 V move nothing";
}

TEST(FaultRig, SpinsForAtLeastTheTimeAsked) {
  timespec before{};
  timespec after{};
  clock_gettime(CLOCK_MONOTONIC, &before);
  spin_for(2'000'000);
  clock_gettime(CLOCK_MONOTONIC, &after);
  EXPECT_GE((after.tv_sec - before.tv_sec) * 1'000'000'000 + after.tv_nsec - before.tv_nsec, 2'000'000);
}

}  // namespace
}  // namespace eha::hal
