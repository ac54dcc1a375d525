// SPDX-License-Identifier: GPL-3.0-or-later
// A plant that does not answer for a while, told from an end stop, from friction and from a tank that runs empty.
#include "ident/validation/unanswered.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kAnswerStep_s = 0.04;
constexpr Eigen::Index kAnswerRows = 2500;

enum class Plant { rod, lag, coasting };

/// Levels of a random input, held 0.4 to 1.6 s, and a rod or a lag that answers to them but from `off_s` to `on_s`. A
/// coasting rod slows down there as its mass does.
Record silent(Plant plant, double off_s, double on_s, std::uint64_t seed) {
  Record record;
  record.step_s = kAnswerStep_s;
  record.input.resize(kAnswerRows);
  record.output.resize(kAnswerRows);
  std::mt19937_64 draw(seed);
  double u = 0.0;
  double velocity = 0.0;
  double y = 0.0;
  Eigen::Index next = 0;
  for (Eigen::Index k = 0; k < kAnswerRows; ++k) {
    // As the rod would leave its travel, the input leads it back.
    if (k == next) {
      u = std::clamp(normal(draw), -2.0, 2.0) - (plant == Plant::lag ? 0.0 : 0.3 * y);
      next += 10 + static_cast<Eigen::Index>(draw() % 30);
    }
    record.input[k] = u;
    record.output[k] = y + 0.003 * normal(draw);
    const double t_s = kAnswerStep_s * static_cast<double>(k);
    const bool answers = t_s < off_s || t_s > on_s;
    const bool coasts = plant == Plant::coasting;
    velocity += ((coasts && !answers ? 0.0 : u) - velocity) * (1.0 - std::exp(-kAnswerStep_s / (coasts ? 0.4 : 0.1)));
    if (coasts) {
      y += kAnswerStep_s * velocity;
    } else if (answers)
      y += plant == Plant::rod ? kAnswerStep_s * velocity : (velocity - y) * kAnswerStep_s / 0.4;
  }
  return record;
}

std::optional<EndStop> found_in(const Record& record) {
  return fit(record, asked_for(structures::io()), {}).model.validation.value().end_stop;
}

TEST(Unanswered, IsFoundAtTheEndAtTheStartAndBetween) {
  int found_at_start = 0;
  for (const Plant plant : {Plant::rod, Plant::lag}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const auto end = found_in(silent(plant, 78.0, 200.0, seed));
      ASSERT_TRUE(end) << seed;
      EXPECT_TRUE(end->does_not_answer) << seed;
      EXPECT_NEAR(end->from_s, 78.0, 1.0) << seed;
      EXPECT_FALSE(end->to_s) << seed;
      ASSERT_TRUE(end->clean_to_s) << seed;
      EXPECT_LT(*end->clean_to_s, 78.0) << seed;
      EXPECT_GT(*end->clean_to_s, 74.0) << seed;
      const auto start = found_in(silent(plant, -1.0, 20.0, seed));
      // Of the part that estimates the model two fifths stand then.
      if (start) {
        ++found_at_start;
        EXPECT_TRUE(start->does_not_answer) << seed;
        EXPECT_NEAR(start->clean_from_s.value_or(0.0), 20.0, 1.0) << seed;
      }
      const auto between = found_in(silent(plant, 40.0, 60.0, seed));
      ASSERT_TRUE(between) << seed;
      EXPECT_TRUE(between->does_not_answer) << seed;
      EXPECT_NEAR(between->from_s, 40.0, 1.0) << seed;
      EXPECT_NEAR(between->to_s.value_or(0.0), 60.0, 1.0) << seed;
    }
  }
  EXPECT_GE(found_at_start, 3) << "of 4";
}

TEST(Unanswered, LeavesOutTheWayOnWhichTheRodOnlyCoasts) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto end = found_in(silent(Plant::coasting, 78.0, 200.0, seed));
    ASSERT_TRUE(end) << seed;
    EXPECT_TRUE(end->does_not_answer) << seed;
    ASSERT_TRUE(end->clean_to_s) << seed;
    EXPECT_LT(*end->clean_to_s, 78.0) << seed;
    EXPECT_GT(*end->clean_to_s, 68.0) << seed;
  }
}

TEST(Unanswered, IsNotFoundWhereThePlantAnswers) {
  for (const Plant plant : {Plant::rod, Plant::lag}) {
    for (std::uint64_t seed = 1; seed <= 4; ++seed) EXPECT_FALSE(found_in(silent(plant, 200.0, 300.0, seed))) << seed;
  }
}

/// The finding in an output that a function of time and input's sum gives, of an input that another one gives.
std::optional<EndStop> found_of(const std::function<double(double)>& volts,
                                const std::function<double(double, double)>& next) {
  Record record;
  record.step_s = kAnswerStep_s;
  record.input.resize(kAnswerRows);
  record.output.resize(kAnswerRows);
  std::mt19937_64 draw(3);
  double y = 0.0;
  for (Eigen::Index k = 0; k < kAnswerRows; ++k) {
    record.input[k] = volts(kAnswerStep_s * static_cast<double>(k));
    record.output[k] = y + 0.003 * normal(draw);
    y = next(y, record.input[k]);
  }
  return found_in(record);
}

TEST(Unanswered, IsNoHighFrequencyNoDeadBandAndNoFriction) {
  const auto sine = [](double f_Hz, double t_s) { return std::cos(2.0 * std::numbers::pi * f_Hz * t_s); };
  const auto rod = [](double y, double u) { return y + kAnswerStep_s * u; };
  // Stepped sines, of which the rod hardly follows the last, and a sweep.
  EXPECT_FALSE(found_of([&](double t) { return sine(t < 40.0 ? 0.1 : t < 70.0 ? 1.0 : 10.0, t); }, rod));
  EXPECT_FALSE(found_of([&](double t) { return sine(0.05 + 0.05 * t, t); }, rod));
  // Small amplitudes within a dead band, after large ones.
  EXPECT_FALSE(
      found_of([&](double t) { return (t < 50.0 ? 2.0 : 0.4) * sine(0.3, t); },
               [&](double y, double u) { return rod(y, std::abs(u) > 0.5 ? u - std::copysign(0.5, u) : 0.0); }));
  // A rod that keeps to a place by friction, with amplitudes little above it.
  EXPECT_FALSE(
      found_of([&](double t) { return (1.0 + 0.3 * sine(0.02, t)) * sine(0.3, t); },
               [&](double y, double u) { return rod(y, std::abs(u) > 0.9 ? u - std::copysign(0.9, u) : 0.0); }));
}

TEST(Unanswered, IsNoRodThatSticksAtHalfOfItsLevels) {
  // Of five levels only the outer two overcome friction.
  std::mt19937_64 draw(5);
  std::vector<double> levels;
  for (int k = 0; k < 200; ++k) levels.push_back(static_cast<double>(static_cast<int>(draw() % 5U) - 2));
  const auto found =
      (found_of([&](double t) { return levels[static_cast<std::size_t>(t / 0.8)]; },
                [&](double y, double u) { return y + (std::abs(u) > 1.2 ? kAnswerStep_s * 0.5 * u : 0.0); }));
  EXPECT_FALSE(found) << found->does_not_answer << " from " << found->from_s << " s, " << found->percent << " %";
}

TEST(EmptyTank, IsNoEndStop) {
  // Filled in the first part of each 25 s, then empty.
  const auto found = found_of(
      [](double t) { return std::fmod(t, 25.0) < 5.0 ? 2.0 : 0.02 * std::sin(t); },
      [](double y, double u) { return std::max(0.0, y + kAnswerStep_s * (u - 0.7 * std::sqrt(std::max(0.0, y)))); });
  EXPECT_FALSE(found) << found->from_s << " " << found->percent;
}

}  // namespace
}  // namespace eha::ident
