// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_line.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha::cli {
namespace {

const std::chrono::system_clock::time_point kNow{};

RunProgress in_mid_stroke() {
  return {.played_s = 12.3,
          .total_s = 50.0,
          .displacement_in = 2.953,
          .applied_V = 1.2,
          .travel_min_in = 0.15,
          .travel_max_in = 5.75,
          .travel_percent = 10.0,
          .margin_in = 0.8};
}

TEST(RunLine, SaysWhatIsLeftWhereTheRodIsAndWhatIsPredicted) {
  const std::string line = run_line(in_mid_stroke(), DisplayUnit(), kNow);
  EXPECT_EQ(line.find("37.7 s left, end "), 0U) << line;
  EXPECT_NE(line.find("  2.953 in, margin 0.80 in  +1.20 V  [==----#----==]  0 late"), std::string::npos) << line;
  EXPECT_LE(line.size(), 100U);
  EXPECT_NE(run_line(in_mid_stroke(), DisplayUnit("mm"), kNow).find("75.006 mm, margin 20.32 mm  +1.20 V"),
            std::string::npos);
}

TEST(RunLine, HasTheRodWithin80ColumnsHoweverManyTicksWereLate) {
  RunProgress progress = in_mid_stroke();
  progress.displacement_in = 5.75;
  progress.applied_V = -1.2;
  progress.late = 12345;
  progress.skipped = 12345;
  progress.margin_in.reset();
  const std::string line = run_line(progress, DisplayUnit("mm"), kNow);
  constexpr std::size_t kBefore = 11;  // "eha: info: "
  EXPECT_LE(line.find(']') + kBefore, 80U) << line;
  EXPECT_NE(line.find("]  12345 late, 12345 skipped"), std::string::npos) << line;
}

TEST(RunLine, SaysNothingOfARunBeforeItsFirstTick) { EXPECT_EQ(run_line({}, DisplayUnit(), kNow), "about to begin"); }

TEST(RunLine, CountsThePreparationWhoseLengthNobodyKnows) {
  RunProgress progress = in_mid_stroke();
  progress.played_s = 0.0;
  progress.elapsed_s = 34.0;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("preparing for 34.0 s, then 50.0 s  2.953 in"), 0U)
      << run_line(progress, DisplayUnit(), kNow);
  progress.is_placing = true;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("50.0 s at most  "), 0U);
}

TEST(RunLine, BoundsTheTimeInWhichARodIsExplored) {
  RunProgress progress = in_mid_stroke();
  progress.played_s = 0.0;
  progress.elapsed_s = 34.0;
  progress.exploring_at_most_s = 900.0;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("exploring, 14:26 min at most, then 50.0 s  2.953 in"), 0U)
      << run_line(progress, DisplayUnit(), kNow);
}

TEST(RunLine, BeginsWithALimitThatIsNear) {
  RunProgress progress = in_mid_stroke();
  progress.travel_percent = 91.0;
  progress.skipped = 2;
  const std::string line = run_line(progress, DisplayUnit(), kNow);
  EXPECT_EQ(line.find("NEAR A LIMIT: 91 % of travel  "), 0U) << line;
  EXPECT_NE(line.find(", 2 skipped"), std::string::npos) << line;
}

TEST(RunLine, BeginsWithRowsThatAreLostBeyondWhatASheetMayLack) {
  RunProgress progress = in_mid_stroke();
  progress.lost_percent = 0.9;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("37.7 s left"), 0U);
  progress.lost_percent = 8.25;
  progress.skipped = 2;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("37.7 s left"), 0U) << "of the first rows";
  progress.skipped = 300;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("ROWS LOST: 8.2 % so far  37.7 s left"), 0U)
      << run_line(progress, DisplayUnit(), kNow);
  progress.is_placing = true;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("ROWS LOST"), std::string::npos) << "a placing makes no sheet";
}

TEST(RunLine, NamesNoEndInVirtualTime) {
  RunProgress progress = in_mid_stroke();
  progress.is_real_time = false;
  progress.total_s = 3 * 3600.0;
  EXPECT_EQ(run_line(progress, DisplayUnit(), kNow).find("2:59 h left  "), 0U);
}

TEST(RunLine, TakesTheMarginFromTheServicesRehearsal) {
  const nlohmann::ordered_json status = {{"run",
                                          {{"experiment_s", 1.0},
                                           {"experiment_total_s", 4.0},
                                           {"fast", true},
                                           {"late", 3},
                                           {"rehearsal", {{"lowest_in", 1.0}, {"highest_in", 5.25}}}}},
                                         {"rod", {{"travel_min_in", 0.15}, {"travel_max_in", 5.75}}}};
  const RunProgress progress = progress_of(status);
  EXPECT_DOUBLE_EQ(progress.margin_in.value_or(0.0), 0.5);
  EXPECT_EQ(progress.late, 3U);
  EXPECT_FALSE(progress.is_real_time);
}

}  // namespace
}  // namespace eha::cli
