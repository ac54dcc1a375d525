// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/watched_lines.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include "core/error.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_options.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/passing_rig.hpp"

namespace eha {
namespace {

/// Counts how often it is read.
class CountingRig final : public test::PassingRig {
 public:
  using PassingRig::PassingRig;
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    ++readings_;
    return PassingRig::read(elapsed_ns, reading);
  }
  /// Returns once it was read so often.
  void wait_for(int readings) const {
    while (readings_ < readings) std::this_thread::yield();
  }

 private:
  std::atomic<int> readings_{0};
};

TEST(WatchedLines, RefuseAfterAnEmergencyStopThatWasResetMeanwhile) {
  const hal::SimOptions plant;
  const std::unique_ptr<hal::Rig> rod = hal::open_rig(plant, 0.0);
  hal::FaultRig rig(
      *rod, {{.kind = hal::FaultKind::emergency_stop, .first_tick = 2, .ticks = 3}}, [](std::int64_t) {},
      plant.conversion());
  CountingRig counted(rig);
  bool is_done = false;
  EXPECT_THROW(with_watched_lines(counted,
                                  [&] {
                                    counted.wait_for(10);
                                    is_done = true;
                                  }),
               DeviceError);
  EXPECT_TRUE(is_done);
}

TEST(WatchedLines, LetSoundLinesAndFailuresOfTheWorkPass) {
  const hal::SimOptions plant;
  const std::unique_ptr<hal::Rig> rod = hal::open_rig(plant, 0.0);
  CountingRig counted(*rod);
  EXPECT_NO_THROW(with_watched_lines(counted, [&] { counted.wait_for(10); }));
  EXPECT_THROW(with_watched_lines(*rod, [] { throw std::runtime_error("of the work"); }), std::runtime_error);
}

}  // namespace
}  // namespace eha
