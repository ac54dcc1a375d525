// SPDX-License-Identifier: GPL-3.0-or-later
// Records of which rows were not measured.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/error.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/signal/intersample.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/structure/structures.hpp"
#include "ident/validation/correlation.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

Record lacking(double share, std::uint64_t seed) {
  Record record = record_of(fractional(0.05, 2.0, 1.0, 0.8, 0.46), 0.02, 0.02, seed);
  std::mt19937_64 generator(seed + 1);
  for (Eigen::Index row = 1; row + 1 < record.output.size(); ++row) {
    if (uniform(generator) < share) record.unmeasured.push_back(static_cast<std::size_t>(row));
  }
  return record;
}

Record with_other_values(Record record, double value) {
  for (const std::size_t row : record.unmeasured) record.output[static_cast<Eigen::Index>(row)] = value;
  return record;
}

TEST(MissingRows, CountForNothing) {
  const Record record = lacking(0.05, 3);
  const Model one = fit(with_other_values(record, 1.0), asked_for(structures::io()), {}).model;
  const Model other = fit(with_other_values(record, 1.3), asked_for(structures::io()), {}).model;
  for (std::size_t i = 0; i < one.parameters.size(); ++i) {
    const ParameterEstimate& p = one.parameters[i];
    EXPECT_NEAR(p.value, other.parameters[i].value, 1e-4 * p.std) << p.name;
    EXPECT_NEAR(p.std, other.parameters[i].std, 1e-4 * p.std) << p.name;
  }
  EXPECT_EQ(one.estimation->score.samples + one.validation->score.samples,
            static_cast<std::size_t>(record.output.size()) - record.unmeasured.size());
  EXPECT_NEAR(one.validation->score.mse, other.validation->score.mse, 1e-6 * one.validation->score.mse);
  EXPECT_NEAR(one.validation->tests->whiteness.p, other.validation->tests->whiteness.p, 1e-3);
  EXPECT_NEAR(one.validation->tests->input.p, other.validation->tests->input.p, 1e-3);
  EXPECT_NEAR(one.validation->ljung_box_p, other.validation->ljung_box_p, 1e-3);
}

TEST(MissingRows, LeaveTheParametersWithinTheirErrors) {
  const Model model = fit(with_other_values(lacking(0.1, 5), 1.0), asked_for(structures::io()), {}).model;
  for (const auto& [name, truth] : {std::pair("a2", 0.05), {"a0", 0.8}, {"K", 0.46}}) {
    const auto p = std::find_if(model.parameters.begin(), model.parameters.end(),
                                [name = name](const ParameterEstimate& one) { return one.name == name; });
    ASSERT_NE(p, model.parameters.end()) << name;
    EXPECT_LT(std::abs(p->value - truth), 3.5 * p->std) << name;
  }
  EXPECT_GT(model.validation->tests->whiteness.p, 0.001);
  EXPECT_GT(model.validation->tests->input.p, 0.001);
}

/// A staircase through a lag; in a twentieth of its rows the input was not measured and is a straight line.
Record with_guessed_input(const Model& lag, std::uint64_t seed) {
  constexpr Eigen::Index kRows = 3000;
  Record record;
  record.step_s = 0.02;
  record.input.resize(kRows);
  std::mt19937_64 generator(seed);
  double level = 0.0;
  for (Eigen::Index k = 0; k < kRows; ++k) {
    if (k % 12 == 0 && uniform(generator) < 0.5) level = std::round(4.0 * uniform(generator)) - 2.0;
    record.input[k] = level;
  }
  record.output = simulate(lag, record.input, record.step_s);
  for (double& y : record.output) y += 0.02 * normal(generator);
  for (Eigen::Index k = 1; k + 1 < kRows; ++k) {
    if (uniform(generator) >= 0.05) continue;
    record.unmeasured.push_back(static_cast<std::size_t>(k));
    record.input[k] = 0.5 * (record.input[k - 1] + record.input[k + 1]);
    ++k;
  }
  return record;
}

TEST(MissingRows, LeaveAGuessOfTheInputThatTheTestsKnowOf) {
  Model lag;
  lag.transfer_function = {{{2.0, 0.0}}, {{0.35, 1.0}, {1.0, 0.0}}, 0.0};
  int alarms = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ResidualTests tests = validate(lag, with_guessed_input(lag, seed), {}).tests.value();
    alarms += tests.nonlinearity->test.p < 0.002 ? 1 : 0;
    alarms += tests.future_input->p < 0.001 ? 1 : 0;
    alarms += tests.input.p < 0.01 ? 1 : 0;
  }
  EXPECT_LE(alarms, 2);
}

TEST(MissingRows, OfADecimatedRecordMatterWhereTheyAreMuchOfAWindow) {
  Record record = lacking(0.0, 1);
  record.unmeasured = {1000};
  const Comparison every_5th = compare_every(2500, 5, 0);
  EXPECT_TRUE(MeasuredRows(record, every_5th).are_all());
  for (std::size_t row = 990; row < 1011; ++row) record.unmeasured.push_back(row);
  std::sort(record.unmeasured.begin(), record.unmeasured.end());
  record.unmeasured.erase(std::unique(record.unmeasured.begin(), record.unmeasured.end()), record.unmeasured.end());
  const MeasuredRows rows(record, every_5th);
  const auto at = static_cast<Eigen::Index>((1000 - every_5th.first) / 5);
  const Eigen::VectorXd weights = rows.weights(static_cast<Eigen::Index>(every_5th.count));
  EXPECT_EQ(weights[at], 0.0);
  EXPECT_EQ(weights[at - 4], 1.0);
  EXPECT_EQ(weights[at + 4], 1.0);
  EXPECT_LE((1.0 - weights.array()).sum(), 5.0);
}

TEST(MissingRows, KeepTheirPlaceInARecordInParts) {
  Record record = lacking(0.0, 1);
  record.unmeasured = {1000, 1001};
  const Record fine = in_parts(record, Intersample::straight);
  const MeasuredRows rows(fine, compare_every(static_cast<std::size_t>(fine.input.size()), kPartsOfARow, 0));
  const Comparison comparison = compare_every(static_cast<std::size_t>(fine.input.size()), kPartsOfARow, 0);
  const Eigen::VectorXd weights = rows.weights(static_cast<Eigen::Index>(comparison.count));
  EXPECT_EQ((1.0 - weights.array()).sum(), 2.0);
  EXPECT_EQ(weights[static_cast<Eigen::Index>((1000 * kPartsOfARow - comparison.first) / kPartsOfARow)], 0.0);
}

TEST(MissingRows, MustLeaveEnoughToEstimateFrom) {
  Record record = lacking(0.0, 1);
  for (std::size_t row = 10; row < 1500; ++row) record.unmeasured.push_back(row);
  EXPECT_THROW(static_cast<void>(fit(record, asked_for(structures::io()), {})), DataError);
}

TEST(MissingRows, AreCountedWithThoseInGaps) {
  Record record = lacking(0.0, 1);
  record.unmeasured = {3, 7, 8, 9, 10, 11, 20, 21, 22, 23};
  const Unmeasured found = unmeasured_of(record);
  EXPECT_EQ(found.rows, 10U);
  EXPECT_EQ(found.in_gaps, 5U);
  EXPECT_DOUBLE_EQ(found.percent(), 0.4);
  EXPECT_EQ(rows_within(record.unmeasured, 8, 13), (std::vector<std::size_t>{0, 1, 2, 3, 12}));
}

TEST(MissingRows, LeaveTheCorrelationsUnbiased) {
  constexpr Eigen::Index kRows = 20000;
  Eigen::VectorXd e(kRows);
  Eigen::VectorXd u(kRows);
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(kRows);
  std::mt19937_64 generator(7);
  double noise = 0.0;
  for (Eigen::Index k = 0; k < kRows; ++k) {
    u[k] = normal(generator);
    noise = 0.8 * noise + 0.6 * normal(generator);
    e[k] = noise + (k > 1 ? 0.5 * u[k - 2] : 0.0);
    if (uniform(generator) < 0.1) weights[k] = 0.0;
  }
  const Eigen::VectorXd spoilt = (weights.array() > 0.0).select(e, Eigen::VectorXd::Constant(kRows, 50.0));
  const Correlation acf = autocorrelation(spoilt, 3, weights);
  const Correlation whole = autocorrelation(e, 3);
  for (std::size_t lag = 0; lag < 4; ++lag) EXPECT_NEAR(acf.values[lag], whole.values[lag], 0.02) << lag;
  EXPECT_NEAR(acf.bound95, whole.bound95 / 0.9, 0.01 * whole.bound95);
  const Correlation ccf = cross_correlation(spoilt, u, 3, weights);
  EXPECT_NEAR(ccf.values[5], 0.5 / std::sqrt(1.25), 0.02) << "at lag 2";
}

}  // namespace
}  // namespace eha::ident
