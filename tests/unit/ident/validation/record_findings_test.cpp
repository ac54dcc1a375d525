// SPDX-License-Identifier: GPL-3.0-or-later
// Rods on an end stop and jumps of the error, told from what looks like them.
#include "ident/validation/record_findings.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/signal/most_moving_part.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kFindingStep_s = 0.04;
constexpr Eigen::Index kFindingRows = 2500;
constexpr double kFindingNoise = 0.0008;  // 0.02 mm

/// A rod y' = 0.15 u between end stops, from mid-travel, with an input that swings about a bias.
Record rod(double highest, double bias, std::uint64_t seed, double lowest = -100.0) {
  Record record;
  record.step_s = kFindingStep_s;
  record.input.resize(kFindingRows);
  record.output.resize(kFindingRows);
  std::mt19937_64 draw(seed);
  double y = 3.0;
  double u = 0.0;
  for (Eigen::Index k = 0; k < kFindingRows; ++k) {
    if (k % 20 == 0) u = bias + 1.5 * std::sin(0.05 * static_cast<double>(k)) + 0.3 * normal(draw);
    record.output[k] = y + kFindingNoise * normal(draw);
    record.input[k] = u;
    y = std::clamp(y + kFindingStep_s * 0.15 * u, lowest, highest);
  }
  return record;
}

ValidationReport report_on(const Record& record, const Structure& structure) {
  return fit(record, asked_for(structure), {}).model.validation.value();
}

TEST(EndStopTest, IsFoundWithItsPlaceAndTimeDespiteNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    // Drifts towards the stop and stays there in the end.
    const Record record = rod(5.0, 0.18, seed);
    const Eigen::VectorXd& y = record.output;
    Eigen::Index first = 0;
    while (y[first] < 5.0 - 4.0 * kFindingNoise) ++first;
    const ValidationReport report = report_on(record, structures::integrator_lag());
    ASSERT_TRUE(report.end_stop) << seed;
    EXPECT_NEAR(report.end_stop->level, 5.0, 0.005) << seed;
    EXPECT_NEAR(report.end_stop->from_s, kFindingStep_s * static_cast<double>(first), 6.0) << seed;
    EXPECT_GT(report.end_stop->percent, 1.0) << seed;
    EXPECT_FALSE(report.jump) << seed;
  }
}

TEST(EndStopTest, IsCutToThePartThatMovesAndNotToALongRest) {
  // On its stop after a while, back from it, and at rest below it for the second half.
  Record record = rod(5.0, 0.18, 1);
  const Eigen::Index rest = kFindingRows / 2;
  std::mt19937_64 draw(2);
  for (Eigen::Index k = rest - 200; k < kFindingRows; ++k) {
    record.input[k] = k < rest ? -1.0 : 0.0;
    const double back = 0.15 * kFindingStep_s * static_cast<double>(std::min(k, rest) - (rest - 200));
    record.output[k] = record.output[rest - 201] - back + kFindingNoise * normal(draw);
  }
  const std::vector<std::pair<std::size_t, std::size_t>> stays{{700, 800}, {900, static_cast<std::size_t>(rest)}};
  const auto part = most_moving_part({record.output.data(), static_cast<std::size_t>(kFindingRows)}, stays);
  ASSERT_TRUE(part);
  EXPECT_LT(part->first, 1000U) << "the rest is the longest part";
  EXPECT_EQ(part->second, 700U);
  // Where the output moves in no part, none is named.
  Eigen::VectorXd still = Eigen::VectorXd::Zero(kFindingRows);
  still.head(50).setOnes();
  EXPECT_FALSE(most_moving_part({still.data(), static_cast<std::size_t>(kFindingRows)}, {{40, 60}}));
  EXPECT_EQ(cut_options(EndStop{}), "");
}

TEST(EndStopTest, TellsTwoStopsFromOne) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Record record = rod(3.15, 0.0, seed, 2.85);
    const FitResult result = fit(record, asked_for(structures::integrator_lag()), {});
    const std::optional<EndStop>& stop = result.model.validation->end_stop;
    ASSERT_TRUE(stop) << seed;
    ASSERT_TRUE(stop->other) << seed;
    EXPECT_NEAR(std::max(stop->level, stop->other->level), 3.15, 0.005) << seed;
    EXPECT_NEAR(std::min(stop->level, stop->other->level), 2.85, 0.005) << seed;
    EXPECT_GT(stop->other->from_s, stop->from_s) << seed;
    const std::string first = judge(result.model, {}).reasons.front();
    EXPECT_EQ(first.rfind("The output stands at two ends (a rod on its end stops", 0), 0U) << first;
    EXPECT_FALSE(
        fit(rod(5.0, 0.18, seed), asked_for(structures::integrator_lag()), {}).model.validation->end_stop.value().other)
        << seed;
  }
}

TEST(EndStopTest, LeavesNoTouchOfAKnownStopInTheCut) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Record record = rod(4.0, 0.1, seed);
    const ValidationReport report = report_on(record, structures::integrator_lag());
    ASSERT_TRUE(report.end_stop) << seed;
    const EndStop& stop = *report.end_stop;
    const auto row = [&](const std::optional<double>& time_s, Eigen::Index otherwise) {
      return time_s ? static_cast<Eigen::Index>(std::lround(*time_s / kFindingStep_s)) : otherwise;
    };
    const Eigen::Index from = row(stop.clean_from_s, 0);
    const Eigen::Index to = row(stop.clean_to_s, kFindingRows);
    Eigen::Index in_row = 0;
    for (Eigen::Index k = from + 1; k + 1 < to; ++k) {
      in_row = record.output[k] >= 4.0 - 2.0 * kFindingNoise ? in_row + 1 : 0;
      ASSERT_LT(in_row, 4) << seed << ": at " << kFindingStep_s * static_cast<double>(k) << " s of "
                           << kFindingStep_s * static_cast<double>(from) << " .. "
                           << kFindingStep_s * static_cast<double>(to);
    }
  }
}

TEST(EndStopTest, IsFoundOnARodThatPositiveVoltsRetract) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Record record = rod(5.0, 0.18, seed);
    record.input = -record.input;
    const ValidationReport report = report_on(record, structures::integrator_lag());
    ASSERT_TRUE(report.end_stop) << seed;
    EXPECT_NEAR(report.end_stop->level, 5.0, 0.005) << seed;
  }
}

TEST(EndStopTest, IsFoundWhereTheRodMovesForAShortTimeOnly) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Record record = rod(3.4, 3.2, seed);  // there after 1 of 100 s, and pressed on
    const ValidationReport report = report_on(record, structures::integrator_lag());
    ASSERT_TRUE(report.end_stop) << seed;
    EXPECT_NEAR(report.end_stop->level, 3.4, 0.005) << seed;
    EXPECT_LT(report.end_stop->from_s, 4.0) << seed;
    EXPECT_GT(report.end_stop->percent, 90.0) << seed;
    EXPECT_LE(report.end_stop->percent, 100.0) << seed;
  }
}

TEST(EndStopTest, IsNotSeenWhereTheRodTurnsBackByItself) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ValidationReport report = report_on(rod(100.0, 0.0, seed), structures::integrator_lag());
    EXPECT_FALSE(report.end_stop) << seed << " at " << report.end_stop->from_s;
    EXPECT_FALSE(report.jump) << seed;
  }
}

TEST(EndStopTest, IsNotSeenWhereALagHasSettled) {
  Record record;
  record.step_s = kFindingStep_s;
  record.input.resize(kFindingRows);
  record.output.resize(kFindingRows);
  std::mt19937_64 draw(3);
  double y = 0.0;
  for (Eigen::Index k = 0; k < kFindingRows; ++k) {
    const double u = (k / 200) % 2 == 0 ? 1.0 : -0.5;
    record.input[k] = u;
    record.output[k] = y + kFindingNoise * normal(draw);
    y += kFindingStep_s * 2.0 * (u - y);
  }
  for (const Structure& structure : {structures::io1(), structures::integrator_lag()}) {
    EXPECT_FALSE(report_on(record, structure).end_stop);
  }
}

TEST(EndStopTest, IsNotSeenWhereTheInputEnds) {
  // 0, 2 and 0 V: the rod stands for the last 40 % because nothing moves it.
  Record record;
  record.step_s = kFindingStep_s;
  record.input.resize(kFindingRows);
  record.output.resize(kFindingRows);
  std::mt19937_64 draw(4);
  double y = 3.0;
  for (Eigen::Index k = 0; k < kFindingRows; ++k) {
    record.input[k] = k > kFindingRows / 10 && k < kFindingRows * 6 / 10 ? 2.0 : 0.0;
    record.output[k] = y + kFindingNoise * normal(draw);
    y += kFindingStep_s * 0.15 * record.input[k];
  }
  EXPECT_FALSE(report_on(record, structures::integrator_lag()).end_stop);
}

TEST(EndStopTest, IsNotSeenWhereTheRodRestsInTheDeadBand) {
  // Steps out, back into the dead band, in, and again: it rests at its greatest value with 0.1 V on the valve.
  Record record;
  record.step_s = kFindingStep_s;
  record.input.resize(kFindingRows);
  record.output.resize(kFindingRows);
  std::mt19937_64 draw(4);
  double y = 3.0;
  for (Eigen::Index k = 0; k < kFindingRows; ++k) {
    const Eigen::Index phase = (k / 100) % 4;
    const double u = phase == 0 ? 0.8 : phase == 2 ? -0.8 : 0.1;
    const double v = std::abs(u) <= 0.15 ? 0.0 : u - std::copysign(0.15, u);
    record.input[k] = u;
    record.output[k] = y + kFindingNoise * normal(draw);
    y += kFindingStep_s * 0.15 * v;
  }
  EXPECT_FALSE(report_on(record, structures::integrator_lag()).end_stop);
}

TEST(ErrorJumpTest, IsFoundAtItsTime) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Record record = rod(100.0, 0.0, seed);
    const auto at = static_cast<Eigen::Index>(1700 + 20 * seed);
    record.output.tail(kFindingRows - at).array() += 0.05;
    const FitResult result = fit(record, asked_for(structures::integrator_lag()), {});
    const ValidationReport& report = result.model.validation.value();
    ASSERT_TRUE(report.jump) << seed;
    EXPECT_NEAR(report.jump->time_s, kFindingStep_s * static_cast<double>(at), 0.2) << seed;
    EXPECT_NEAR(report.jump->change, 0.05, 0.01) << seed;
    const Verdict verdict = judge(result.model, {});
    EXPECT_EQ(verdict.reasons.front().rfind("The error jumps by 0.0", 0), 0U) << verdict.reasons.front();
  }
}

TEST(ErrorJumpTest, IsCutSafelyOnEachSide) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Record record = rod(100.0, 0.0, seed);
    const auto at = static_cast<Eigen::Index>(1700 + 7 * seed);
    record.output.tail(kFindingRows - at).array() += 0.05;
    const FitResult result = fit(record, asked_for(structures::integrator_lag()), {});
    ASSERT_TRUE(result.model.validation->jump) << seed;
    const CutBeside cut = cut_beside(*result.model.validation->jump, result.model.estimation->compared_step_s);
    const double at_s = kFindingStep_s * static_cast<double>(at);
    EXPECT_LT(cut.to_s, at_s - kFindingStep_s) << seed;
    EXPECT_GT(cut.to_s, at_s - 2.0) << seed;
    EXPECT_GT(cut.from_s, at_s + kFindingStep_s) << seed;
    EXPECT_LT(cut.from_s, at_s + 2.0) << seed;
  }
}

TEST(ErrorJumpTest, IsCutAtTimesOfFewDigits) {
  const CutBeside near = cut_beside({.time_s = 29.98, .change = 1.0}, 0.02);
  EXPECT_DOUBLE_EQ(near.to_s, 29.90);
  EXPECT_DOUBLE_EQ(near.from_s, 30.06);
  const CutBeside late = cut_beside({.time_s = 12345.67, .change = 1.0}, 0.02);
  EXPECT_NEAR(late.to_s, 12345.59, 0.011);
  EXPECT_NEAR(late.from_s, 12345.75, 0.011);
}

TEST(ErrorJumpTest, IsFoundWhereRowsAreMissingAtSeveralPlaces) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Record whole = rod(100.0, 0.0, seed);
    const Eigen::VectorXd time =
        whole.step_s * Eigen::VectorXd::LinSpaced(whole.output.size(), 0.0, kFindingRows - 1.0);
    const Eigen::VectorXd model = whole.output;
    const auto jump_of = [&](const std::vector<Eigen::Index>& places, double falls_by) {
      Eigen::VectorXd measured = model;
      std::mt19937_64 random(seed);
      std::normal_distribution<double> noise(0.0, 0.001);
      for (double& y : measured) y += noise(random);
      double by = 0.05;
      for (const Eigen::Index at : places) measured.tail(measured.size() - at).array() += (by *= -falls_by);
      return error_jump({time, whole.input, measured, model});
    };
    const std::optional<ErrorJump> jump = jump_of({600, 1700}, 0.8);
    ASSERT_TRUE(jump) << seed;
    EXPECT_NEAR(jump->time_s, time[600], 0.2) << "the greatest";
    EXPECT_NEAR(jump->change, -0.04, 0.005);
    EXPECT_FALSE(jump_of({300, 500, 700, 900, 1100, 1300, 1500}, 0.99)) << "too many for a loss here and there";
  }
}

/// A rod that goes to and fro about every 20 s, and an error that dry friction turns round at each turn, more in one
/// swing.
std::optional<ErrorJump> jump_beside_friction(std::uint64_t seed, Eigen::Index slip_at, double slip) {
  const Eigen::VectorXd time = 0.04 * Eigen::VectorXd::LinSpaced(2500, 0.0, 2499.0);
  const Eigen::VectorXd model = (0.05 * 2.0 * std::numbers::pi * time.array()).sin();  // turns at 5, 15, .. 95 s
  Eigen::VectorXd measured = model;
  std::mt19937_64 draw(seed);
  for (Eigen::Index k = 0; k < time.size(); ++k) {
    const bool is_forth = std::fmod(time[k] + 4.8, 20.0) < 10.0;
    const double friction = is_forth && time[k] > 75.0 && time[k] < 86.0 ? 0.0055 : is_forth ? 0.002 : -0.002;
    measured[k] += friction + 0.0001 * normal(draw);
    if (k >= slip_at) measured[k] += slip;
  }
  return error_jump({time, model, measured, model});
}

TEST(ErrorJumpTest, IsNotAStepOfFrictionWhereTheMotionTurns) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto friction = jump_beside_friction(seed, 0, 0.0);
    EXPECT_FALSE(friction) << seed << ": " << friction->change << " at " << friction->time_s;
    // A sensor that slips in mid-motion, and one that slips at a turn by clearly more than friction does there.
    const auto away = jump_beside_friction(seed, 1000, 0.009);
    ASSERT_TRUE(away) << seed;
    EXPECT_NEAR(away->time_s, 40.0, 0.2) << seed;
    const auto at_a_turn = jump_beside_friction(seed, 1128, 0.03);
    ASSERT_TRUE(at_a_turn) << seed;
    EXPECT_NEAR(at_a_turn->time_s, 45.1, 0.3) << seed;
  }
}

TEST(ErrorJumpTest, IsNotASlowErrorAcrossAGap) {
  const Eigen::VectorXd all = 0.04 * Eigen::VectorXd::LinSpaced(2500, 0.0, 2499.0);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto jump_of = [&](double slip) {
      // 16 rows without a measurement, in one of the ramps of 2 s in which the error goes from level to level.
      Eigen::VectorXd time(all.size() - 16);
      time << all.head(1200), all.tail(all.size() - 1216);
      const Eigen::VectorXd model = (0.05 * 2.0 * std::numbers::pi * time.array()).sin();
      std::mt19937_64 draw(seed);
      Eigen::VectorXd measured = model;
      for (Eigen::Index k = 0; k < time.size(); ++k) {
        const double ramp = std::remainder(time[k] - all[1208], 10.0);  // up at 0, down at 5 s
        const double level = std::abs(ramp) < 2.5 ? ramp : std::copysign(5.0, ramp) - ramp;
        measured[k] += 0.02 * std::clamp(level, -1.0, 1.0) + 0.0002 * normal(draw);
        if (k >= 1200) measured[k] += slip;
      }
      return error_jump({time, model, measured, model});
    };
    const auto slow = jump_of(0.0);
    EXPECT_FALSE(slow) << seed << ": " << slow->change << " at " << slow->time_s;
    EXPECT_TRUE(jump_of(0.08)) << seed << ": a sensor that slipped in the gap";
  }
}

TEST(ErrorJumpTest, IsNotAPulseNorNoise) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Record record = rod(100.0, 0.0, seed);
    record.output[1800] += 0.05;
    EXPECT_FALSE(report_on(record, structures::integrator_lag()).jump) << seed;
  }
}

/// Levels to a lag, 8 mm/V and 0.2 s, of which some rows are missing.
Record lag_that_lost_rows(Eigen::Index at, Eigen::Index lost, std::uint64_t seed) {
  constexpr Eigen::Index kKept = 4000;
  std::mt19937_64 draw(seed);
  const Eigen::Index all = kKept + lost;
  Eigen::VectorXd input(all);
  for (Eigen::Index k = 0; k < all; ++k) input[k] = k % 40 == 0 ? 2.0 * uniform(draw) - 1.0 : input[k - 1];
  const Eigen::VectorXd output = simulate({{{8.0, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0}, input, 0.02);
  Record record;
  record.step_s = 0.02;
  record.input.resize(kKept);
  record.output.resize(kKept);
  for (Eigen::Index k = 0; k < kKept; ++k) {
    const Eigen::Index row = k < at ? k : k + lost;
    record.input[k] = input[row];
    record.output[k] = output[row] + 0.02 * normal(draw);
  }
  return record;
}

TEST(ErrorBurstTest, IsWhereRowsWereLostOfAPlantThatComesToRest) {
  for (const Eigen::Index at : {1210, 3130}) {
    const Record record = lag_that_lost_rows(at, 130, 4);
    const ValidationReport report = report_on(record, structures::io1());
    ASSERT_TRUE(report.jump) << at;
    ASSERT_TRUE(report.jump->until_s) << at;
    const double at_s = 0.02 * static_cast<double>(at);
    EXPECT_NEAR(report.jump->time_s, at_s, 0.1);
    EXPECT_GT(*report.jump->until_s, at_s);
    EXPECT_LT(*report.jump->until_s, at_s + 2.0);
    const CutBeside cut = cut_beside(*report.jump, 0.02);
    EXPECT_LT(cut.to_s, at_s);
    EXPECT_GT(cut.from_s, *report.jump->until_s);
    EXPECT_NE(jump_text(*report.jump, "mm").find(" and far less elsewhere"), std::string::npos);
  }
  EXPECT_FALSE(report_on(lag_that_lost_rows(2000, 0, 4), structures::io1()).jump);
}

}  // namespace
}  // namespace eha::ident
