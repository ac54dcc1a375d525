// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/sensor_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ident/estimation/fit.hpp"
#include "ident/validation/signal_facts.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kStep = 0.1;
const double kFull = kStep / std::sqrt(12.0);

Record rounded(Eigen::VectorXd output, double noise = 0.0) {
  std::mt19937_64 draw(7);
  Record record;
  record.step_s = 0.02;
  record.input = Eigen::VectorXd::Zero(output.size());
  for (double& y : output) y = kStep * std::round((y + noise * normal(draw)) / kStep);
  record.output = std::move(output);
  return record;
}

Eigen::MatrixXd stays_of(const Record& record) {
  Comparison every_row;
  every_row.count = static_cast<std::size_t>(record.output.size());
  return rounded_stays(record, SignalFacts(record).output_step(), every_row, 0);
}

/// Levels, each held for 100 rows.
Eigen::VectorXd staircase() {
  std::mt19937_64 draw(3);
  Eigen::VectorXd y(6000);
  for (Eigen::Index k = 0; k < y.size(); ++k) y[k] = k % 100 == 0 ? uniform(draw) - 0.5 : y[k - 1];
  return y;
}

TEST(RoundedStays, AreTheDwellsOfASignalAtRest) {
  const Eigen::MatrixXd stays = stays_of(rounded(staircase()));
  ASSERT_GT(stays.cols(), 40) << "of 60 levels, where none is that of before";
  EXPECT_NEAR(stays.maxCoeff(), kFull, 1e-12);
}

TEST(RoundedStays, LeaveOutASlowWayThroughTheSteps) {
  Eigen::VectorXd y(4000);
  for (Eigen::Index k = 0; k < y.size(); ++k) y[k] = 0.97 * std::sin(0.005 * static_cast<double>(k));
  const Eigen::MatrixXd stays = stays_of(rounded(y));
  EXPECT_GT(stays.cols(), 0) << "the turning points";
  EXPECT_LT(stays.cols(), 26) << "of some 120 stays";
}

TEST(RoundedStays, CountLittleWhereNoiseMovesTheReadings) {
  for (const double noise : {0.1, 0.2, 0.3}) {  // steps
    const Eigen::MatrixXd stays = stays_of(rounded(staircase(), noise * kStep));
    const double expected = std::exp(-2.0 * std::numbers::pi * std::numbers::pi * noise * noise);
    ASSERT_GT(stays.cols(), 0);
    EXPECT_NEAR(stays.maxCoeff() / kFull, expected, 0.15) << noise;
  }
}

/// Share of records in whose 95 % interval the gain of a lag lies, which moves among levels and rests there.
double coverage_of_gain(Eigen::Index held, double noise) {
  Model truth;
  truth.transfer_function = {{{0.46, 0.0}}, {{1.0, 1.0}, {1.6, 0.0}}, 0.0};
  StructureOptions asked = asked_for(structures::io1());
  asked.initial_state = InitialState::none;
  FitOptions options;
  options.search = Search::local;
  constexpr int kRecords = 20;
  int inside = 0;
  for (int seed = 1; seed <= kRecords; ++seed) {
    std::mt19937_64 draw(static_cast<std::uint64_t>(seed));
    Eigen::VectorXd u(1500);
    for (Eigen::Index k = 0; k < u.size(); ++k) u[k] = k % held == 0 ? 2.0 * uniform(draw) - 1.0 : u[k - 1];
    Record record = rounded(simulate(truth, u, 0.02), noise * kStep);
    record.input = u;
    for (const ParameterEstimate& p : fit(record, asked, options).model.parameters) {
      if (p.name != "K") continue;
      inside += p.lower95 <= 0.46 && 0.46 <= p.upper95 ? 1 : 0;
    }
  }
  return static_cast<double>(inside) / kRecords;
}

TEST(RoundedStays, LetTheIntervalHoldTheTruth) {
  for (const Eigen::Index held : {20, 100, 400}) {
    for (const double noise : {0.0, 0.15, 0.35}) {
      const double share = coverage_of_gain(held, noise);
      std::printf("levels held for %d rows, noise of %.2f steps: K in its interval in %.0f %%\n",
                  static_cast<int>(held), noise, 100.0 * share);
      EXPECT_GE(share, 0.8) << held << " " << noise;
    }
  }
}

TEST(RoundedStays, TakeNoMoreMemoryOfALongRecord) {
  Eigen::VectorXd output(1'000'000);
  for (Eigen::Index k = 0; k < output.size(); ++k) output[k] = kStep * static_cast<double>((k / 5'000) * 7 % 20);
  const Eigen::MatrixXd stays = stays_of(rounded(output));
  EXPECT_GE(stays.cols(), 1);
  EXPECT_LE(stays.size(), Eigen::Index{1} << 23);
}

}  // namespace
}  // namespace eha::ident
