// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/loop_in_record.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kLoopStep_s = 0.01;
constexpr Eigen::Index kLoopRows = 4000;

/// A lag of gain 2 and 0.5 s, its output with noise. @param command  of row and reading
Record loop_record_of(
    const std::function<double(Eigen::Index, double)>& command, double noise, std::mt19937_64& draw,
    const std::function<double(double)>& valve = [](double u) { return u; }) {
  Record record;
  record.step_s = kLoopStep_s;
  record.input.resize(kLoopRows);
  record.output.resize(kLoopRows);
  const double left = std::exp(-kLoopStep_s / 0.5);
  double x = 0.0;
  for (Eigen::Index k = 0; k < kLoopRows; ++k) {
    record.output[k] = x + noise * normal(draw);
    record.input[k] = command(k, record.output[k]);
    x = left * x + (1.0 - left) * 2.0 * valve(record.input[k]);
  }
  return record;
}

/// Levels at random, each held for `rows`.
Eigen::VectorXd levels(Eigen::Index rows, std::mt19937_64& draw) {
  Eigen::VectorXd u(kLoopRows);
  for (Eigen::Index k = 0; k < kLoopRows; ++k) u[k] = k % rows == 0 ? 2.0 * uniform(draw) - 1.0 : u[k - 1];
  return u;
}

TEST(SameRowCorrelation, IsThatOfAControllerWhoseReferenceStands) {
  std::mt19937_64 draw(1);
  const auto hold = [](Eigen::Index, double y) { return 2.0 * (1.0 - y); };
  EXPECT_NEAR(same_row_correlation(loop_record_of(hold, 0.1, draw)), -1.0, 1e-9);
  const Eigen::VectorXd reference = levels(100, draw);
  const auto open = [&](Eigen::Index k, double) { return reference[k]; };
  EXPECT_GT(same_row_correlation(loop_record_of(open, 0.1, draw)), 0.0);
  Record still;
  still.input = Eigen::VectorXd::Ones(10);
  still.output = Eigen::VectorXd::Ones(10);
  EXPECT_EQ(same_row_correlation(still), 0.0);
}

TEST(LoopInRecord, IsSeenWhereTheNoiseGoesRoundIt) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 draw(seed);
    const Eigen::VectorXd reference = levels(100, draw);
    const auto loop = [&](double gain) {
      return [&reference, gain](Eigen::Index k, double y) { return gain * (reference[k] - y); };
    };
    for (const double gain : {2.0, 4.0}) {
      const auto found = loop_in_record(loop_record_of(loop(gain), 0.1, draw));
      ASSERT_TRUE(found.has_value()) << seed;
      EXPECT_LT(found->correlation, -0.5);
    }
  }
}

TEST(LoopInRecord, IsQuietWhereItsReferenceMakesMostOfTheInput) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 draw(seed);
    const Eigen::VectorXd reference = levels(100, draw);
    double way = 0.0;
    const auto loop = [&](Eigen::Index k, double y) {
      way += std::clamp(reference[k] - way, -0.02, 0.02);
      return 8.0 * (way - y);
    };
    const auto found = loop_in_record(loop_record_of(loop, 0.003, draw));
    ASSERT_TRUE(found.has_value()) << seed;
    EXPECT_TRUE(found->is_quiet) << seed;
    EXPECT_LT(found->correlation, -0.8) << seed;
  }
}

TEST(LoopInRecord, IsSeenWhereTheLoadMovesTheRodAndTheReferenceStands) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 draw(seed);
    const Eigen::VectorXd load = levels(200, draw);
    double sum = 0.0;
    double command = 0.0;
    Record record = loop_record_of(
        [&](Eigen::Index k, double y) {
          sum += 0.05 * (1.0 - y);
          command = 3.0 * (1.0 - y) + sum;
          return command + load[k];
        },
        0.003, draw);
    record.input -= load;  // the logger has the command, and the load is not recorded
    const auto found = loop_in_record(record);
    ASSERT_TRUE(found.has_value()) << seed;
    EXPECT_LT(found->correlation, -0.9) << seed;
  }
}

TEST(LoopInRecord, IsNotSeenInOpenLoop) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 draw(seed);
    const auto sine = [](Eigen::Index k) { return std::sin(2.0 * std::numbers::pi * static_cast<double>(k) / 157.0); };
    const auto dead_band = [](double u) { return std::abs(u) < 0.3 ? 0.0 : u - std::copysign(0.3, u); };
    const auto limited = [](double u) { return std::clamp(u, -0.4, 0.4); };
    for (const Eigen::Index rows : {Eigen::Index{1}, Eigen::Index{10}, Eigen::Index{100}}) {
      const Eigen::VectorXd u = levels(rows, draw);
      const auto played = [&](Eigen::Index k, double) { return u[k]; };
      EXPECT_FALSE(loop_in_record(loop_record_of(played, 0.1, draw)).has_value()) << seed;
      EXPECT_FALSE(loop_in_record(loop_record_of(played, 0.001, draw, dead_band)).has_value()) << seed;
      EXPECT_FALSE(loop_in_record(loop_record_of(played, 0.0, draw, limited)).has_value()) << seed;
    }
    const auto smooth = [&](Eigen::Index k, double) { return sine(k) + 0.5 * sine(3 * k + 40); };
    EXPECT_FALSE(loop_in_record(loop_record_of(smooth, 0.001, draw, dead_band)).has_value()) << seed;
  }
}

struct FastPlant {
  std::vector<double> a;  // of the rows of the output before
  std::vector<double> b;  // of the input, from the same row on
};

TEST(LoopInRecord, IsNotSeenOfPlantsThatAnswerInTheSameRow) {
  const std::vector<FastPlant> plants{{{}, {1.0}},
                                      {{}, {-1.0}},
                                      {{0.9}, {1.0, -0.8}},
                                      {{0.95}, {1.0, -0.99}},
                                      {{0.1}, {0.9}},
                                      {{}, {-1.0, 3.0}},
                                      {{0.9}, {-0.5, 1.0}},
                                      {{0.98}, {-0.5, 0.55}},
                                      {{1.2, -0.36}, {-0.3, 0.5, 0.1}},
                                      {{1.6, -0.9}, {-0.1, 0.3, 0.2}}};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    std::mt19937_64 draw(seed);
    for (const Eigen::Index rows : {Eigen::Index{1}, Eigen::Index{3}, Eigen::Index{10}}) {
      for (const double noise : {0.0, 0.001, 0.01, 0.1}) {
        for (std::size_t nth = 0; nth < plants.size(); ++nth) {
          Record record;
          record.step_s = kLoopStep_s;
          record.input = levels(rows, draw);
          record.input.head(10).setZero();
          record.output = Eigen::VectorXd::Zero(kLoopRows);
          for (Eigen::Index k = 10; k < kLoopRows; ++k) {
            for (std::size_t i = 0; i < plants[nth].b.size(); ++i) {
              record.output[k] += plants[nth].b[i] * record.input[k - static_cast<Eigen::Index>(i)];
            }
            for (std::size_t i = 0; i < plants[nth].a.size(); ++i) {
              record.output[k] += plants[nth].a[i] * record.output[k - 1 - static_cast<Eigen::Index>(i)];
            }
          }
          for (double& y : record.output) y += noise * normal(draw);
          EXPECT_FALSE(loop_in_record(record).has_value())
              << "plant " << nth << ", noise " << noise << ", levels of " << rows << " rows, seed " << seed;
        }
      }
    }
  }
}

}  // namespace
}  // namespace eha::ident
