// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/early_end.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

namespace eha::play {
namespace {

using Stage = acquisition::CommandSource::Stage;

class Judge final : public EarlyEnd {
 public:
  void note(int repetitions) override {
    is_reached_ = repetitions >= 2;
    judged_ = repetitions;
  }
};

/// Rows that are played before the source is over.
std::uint32_t rows_played(EarlyEndSource& source) {
  const hal::RigReading reading;
  std::uint32_t row = 0;
  while (row < source.rows() && source.stage() != Stage::over) static_cast<void>(source.voltage_V(row++, reading));
  return row;
}

class EarlyEnds : public testing::Test {
 protected:
  EarlyEndSource source(acquisition::TimeBase time_base) {
    return {std::make_unique<acquisition::TableSource>(volts, 4), judge, time_base};
  }
  std::vector<double> volts = std::vector<double>(5, 1.0);
  Judge judge;
};

TEST(EarlyEndsOfALoop, TakeAndLeaveTheLackingWay) {
  struct Loop final : acquisition::CommandSource {
    void go_on_from(const acquisition::LackingWay& lacking) noexcept override { way = lacking; }
    [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return &way; }
    [[nodiscard]] std::uint32_t rows() const noexcept override { return 1; }
    [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return 1; }
    [[nodiscard]] double voltage_V(std::uint32_t, const hal::RigReading&) noexcept override { return 0.0; }
    acquisition::LackingWay way = {};
  };
  const Judge judge;
  EarlyEndSource source(std::make_unique<Loop>(), judge, acquisition::TimeBase::monotonic);
  source.go_on_from({.way_in = 0.2});
  ASSERT_NE(source.lacking(), nullptr);
  EXPECT_EQ(source.lacking()->way_in, 0.2);
}

TEST_F(EarlyEnds, PlayEveryRepetitionWhileNothingIsReached) {
  EarlyEndSource played = source(acquisition::TimeBase::monotonic);
  EXPECT_EQ(rows_played(played), 20U);
  EXPECT_FALSE(played.ended_early());
}

TEST_F(EarlyEnds, EndWithTheRepetitionInWhichTheyAreReached) {
  EarlyEndSource played = source(acquisition::TimeBase::monotonic);
  const hal::RigReading reading;
  for (std::uint32_t row = 0; row < 12; ++row) {
    ASSERT_EQ(played.stage(), Stage::playing) << row;
    static_cast<void>(played.voltage_V(row, reading));
  }
  judge.note(2);
  for (std::uint32_t row = 12; row < 15; ++row) {
    ASSERT_EQ(played.stage(), Stage::playing) << "within a repetition, at row " << row;
    static_cast<void>(played.voltage_V(row, reading));
  }
  EXPECT_EQ(played.stage(), Stage::over);
  EXPECT_TRUE(played.ended_early());
}

TEST_F(EarlyEnds, WaitInVirtualTimeForTheVerdictOfTheRepetitionBefore) {
  EarlyEndSource played = source(acquisition::TimeBase::virtual_time);
  std::thread other([this] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    judge.note(1);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    judge.note(2);
  });
  // The third repetition is played while the second is judged.
  EXPECT_EQ(rows_played(played), 15U);
  other.join();
}

TEST_F(EarlyEnds, PlayToTheEndInVirtualTimeWhenNothingIsJudgedAnyMore) {
  EarlyEndSource played = source(acquisition::TimeBase::virtual_time);
  judge.give_up();
  EXPECT_EQ(rows_played(played), 20U);
}

}  // namespace
}  // namespace eha::play
