// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/watched_lines.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <stdexcept>
#include <thread>

#include "core/error.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_options.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha {
namespace {

void work() { std::this_thread::sleep_for(std::chrono::milliseconds(200)); }

TEST(WatchedLines, RefuseAfterAnEmergencyStopThatWasResetMeanwhile) {
  const hal::SimOptions plant;
  const std::unique_ptr<hal::Rig> rod = hal::open_rig(plant, 0.0);
  hal::FaultRig rig(
      *rod, {{.kind = hal::FaultKind::emergency_stop, .first_tick = 2, .ticks = 3}}, [](std::int64_t) {},
      plant.conversion());
  bool is_done = false;
  EXPECT_THROW(with_watched_lines(rig,
                                  [&] {
                                    work();
                                    is_done = true;
                                  }),
               DeviceError);
  EXPECT_TRUE(is_done);
}

TEST(WatchedLines, LetSoundLinesAndFailuresOfTheWorkPass) {
  const hal::SimOptions plant;
  const std::unique_ptr<hal::Rig> rod = hal::open_rig(plant, 0.0);
  EXPECT_NO_THROW(with_watched_lines(*rod, work));
  EXPECT_THROW(with_watched_lines(*rod, [] { throw std::runtime_error("of the work"); }), std::runtime_error);
}

}  // namespace
}  // namespace eha
