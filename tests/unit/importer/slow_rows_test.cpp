// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/slow_rows.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace eha::importer {
namespace {

struct LoggedRows {
  Eigen::VectorXd input;
  Eigen::VectorXd output;
};

/// Every `every`th of fine rows of 10 ms of a lag behind levels of a random input.
LoggedRows rows_of(double lag_s, int hold_rows, int every, bool integrates, bool is_aligned = false) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const Eigen::Index rows = 600;
  Eigen::VectorXd input(rows);
  Eigen::VectorXd output(rows);
  double u = 0.0;
  double y = 0.0;
  int next = 0;
  for (int k = 0; k < rows * every; ++k) {
    if (k == next) {
      u = normal(random) - (integrates ? 0.1 * y : 0.0);
      next += hold_rows / 2 + static_cast<int>(random() % static_cast<unsigned>(hold_rows));
      if (is_aligned) next += every - next % every;
    }
    if (k % every == 0) {
      input[k / every] = u;
      output[k / every] = y + 0.01 * normal(random);
    }
    y += integrates ? 0.01 * u : (1.0 - std::exp(-0.01 / lag_s)) * (u - y);
  }
  return {input, output};
}

std::string remark_on(double lag_s, int hold_rows, int every, bool integrates = false) {
  const LoggedRows rows = rows_of(lag_s, hold_rows, every, integrates);
  return remark_on_slow_rows(rows.input, rows.output, 0.01 * every);
}

TEST(SlowRows, AreNamedWhereTheOutputAnswersWithinOne) {
  for (const int hold : {60, 150, 400}) {
    const std::string remark = remark_on(0.1, hold, 100);
    EXPECT_NE(remark.find("within one row of 1 s"), std::string::npos) << hold << ": " << remark;
    EXPECT_NE(remark.find("too slow"), std::string::npos) << remark;
  }
}

TEST(SlowRows, OfALongRecordAreSeenByPartsOfIt) {
  const LoggedRows slow = rows_of(0.1, 150, 100, false);
  const LoggedRows quick = rows_of(0.5, 60, 5, false);
  constexpr Eigen::Index kTimes = 750;  // 450 000 rows
  const auto again = [&](const Eigen::VectorXd& part) -> Eigen::VectorXd { return part.replicate(kTimes, 1); };
  EXPECT_NE(remark_on_slow_rows(again(slow.input), again(slow.output), 1.0).find("too slow"), std::string::npos);
  EXPECT_NE(motion_within_rows(again(slow.input), again(slow.output), 1.0).find("too slow"), std::string::npos);
  EXPECT_EQ(remark_on_slow_rows(again(quick.input), again(quick.output), 0.05), "");
}

TEST(SlowRows, AreNotNamedWhereTheyShowTheAnswer) {
  for (const int hold : {20, 60, 400}) {
    for (const int every : {1, 2, 5, 10}) EXPECT_EQ(remark_on(0.5, hold, every), "") << hold << " " << every;
    EXPECT_EQ(remark_on(0.1, hold, 2), "") << hold;
    EXPECT_EQ(remark_on(0.1, hold, 5, true), "") << hold;
    EXPECT_EQ(remark_on(0.1, hold, 100, true), "") << hold;
  }
}

TEST(SlowRows, AreTheCauseOfAnErrorOfARodTooWhereTheInputMovesBetweenThem) {
  for (const int hold : {60, 150, 400}) {
    for (const bool integrates : {false, true}) {
      const LoggedRows slow = rows_of(0.1, hold, 100, integrates);
      EXPECT_NE(motion_within_rows(slow.input, slow.output, 1.0).find("too slow"), std::string::npos) << hold;
      // An input that moves with the rows is known.
      for (const int every : {5, 10}) {
        const LoggedRows even = rows_of(0.5, hold, every, integrates, true);
        EXPECT_EQ(motion_within_rows(even.input, even.output, 0.01 * every), "") << hold << " " << every;
      }
    }
  }
}

TEST(SlowRows, AreNotTheCauseWhereAControllerMakesTheInputFromTheOutput) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  LoggedRows rows{Eigen::VectorXd(1500), Eigen::VectorXd(1500)};
  double reference = 0.0;
  double y = 0.0;
  for (Eigen::Index k = 0; k < 1500; ++k) {
    if (k % 200 == 0) reference = normal(random);
    rows.output[k] = y + 0.005 * normal(random);
    rows.input[k] = 2.0 * (reference - rows.output[k]);
    y += 0.05 * 1.2 * rows.input[k];
  }
  EXPECT_EQ(motion_within_rows(rows.input, rows.output, 0.05), "");
}

}  // namespace
}  // namespace eha::importer
