// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/motion_at_rest.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/sim/sim_rig.hpp"
#include "tests/unit/passing_rig.hpp"

namespace eha {
namespace {

/// Gives readings in order [in]; none: the call times out.
class ScriptedRig final : public test::PassingRig {
 public:
  ScriptedRig(hal::Rig& rig, std::vector<std::optional<double>> places_in)
      : PassingRig(rig), places_in_(std::move(places_in)) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const std::optional<double> place_in = places_in_[calls_++ % places_in_.size()];
    if (!place_in) return hal::RigStatus::timed_out;
    const hal::RigStatus status = PassingRig::read(elapsed_ns, reading);
    reading.displacement_in = *place_in;
    return status;
  }
  [[nodiscard]] std::size_t calls() const { return calls_; }

 private:
  std::vector<std::optional<double>> places_in_;
  std::size_t calls_ = 0;
};

class RodAtRestBeforeTheFirstTick : public ::testing::Test {
 protected:
  /// Of a rod that stood at 3 in. @returns what was thrown, "" without
  std::string compared(std::vector<std::optional<double>> places_in) {
    ScriptedRig rig(*sim_, std::move(places_in));
    std::string said;
    try {
      require_at_rest(rig, {.at = std::chrono::steady_clock::now(), .place_in = 3.0}, DisplayUnit("in"));
    } catch (const RodMoved& error) {
      said = error.what();
    }
    calls_ = rig.calls();
    return said;
  }

  std::unique_ptr<hal::Rig> sim_ = hal::open_rig(hal::SimOptions{}, 0.0);
  std::size_t calls_ = 0;
};

TEST_F(RodAtRestBeforeTheFirstTick, IsTakenWhereItStood) {
  EXPECT_EQ(compared({3.05}), "");
  EXPECT_EQ(calls_, 1U);
}

TEST_F(RodAtRestBeforeTheFirstTick, IsNotDrivenWhereEachReadingHasMoved) {
  EXPECT_EQ(compared({1.5}).rfind("the rod's reading moved by -1.5 in while nothing drove it: nothing is driven", 0),
            0U);
}

TEST_F(RodAtRestBeforeTheFirstTick, IsTakenAfterInterferenceInOneReading) { EXPECT_EQ(compared({1.5, 3.0}), ""); }

/// A reading that fails neither excuses a rod that moved nor stands for one.
TEST_F(RodAtRestBeforeTheFirstTick, IsJudgedByTheReadingsThatSucceed) {
  EXPECT_NE(compared({std::nullopt, 1.5, std::nullopt}), "");
  EXPECT_NE(compared({1.5, std::nullopt, std::nullopt}), "");
  EXPECT_NE(compared({std::nullopt, std::nullopt, 1.5}), "");
  EXPECT_EQ(compared({std::nullopt, 3.0}), "");
  EXPECT_EQ(compared({1.5, std::nullopt, 3.0}), "");
}

/// The loop's own faults are for a card that cannot be read.
TEST_F(RodAtRestBeforeTheFirstTick, IsLeftToTheLoopWhereNoReadingSucceeds) {
  EXPECT_EQ(compared({std::nullopt}), "");
  EXPECT_EQ(calls_, 3U);
}

}  // namespace
}  // namespace eha
