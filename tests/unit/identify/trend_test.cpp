// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/trend.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "daemon/identify/comparison.hpp"
#include "daemon/identify/scored_model.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/validation/slow_pair.hpp"

namespace eha::identify {
namespace {

/// 60 s of random levels to a lag, 1.8 mm/V and 0.5 s. @param drift  of the output over the record [mm]
Source lag_with_drift(double drift, std::uint64_t seed) {
  ident::PortableDraw draw(seed);
  Source source;
  source.name = "drift.csv";
  source.record.step_s = 0.05;
  source.record.input_channel = {"valve", "V"};
  source.record.output_channel = {"rod", "mm"};
  source.record.input.resize(1200);
  double level = 1.0;
  for (Eigen::Index k = 0; k < 1200; ++k) {
    if (k % 20 == 0) level = 2.0 * draw.uniform();
    source.record.input[k] = level;
  }
  source.record.output = ident::simulate({{{1.8, 0.0}}, {{0.5, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input, 0.05);
  for (Eigen::Index k = 0; k < 1200; ++k) {
    source.record.output[k] += 0.004 * draw.normal() + drift * static_cast<double>(k) / 1200.0;
  }
  return source;
}

TEST(Trend, IsFoundWithAnIntervalThatHoldsIt) {
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto trend = trend_of(task_of(lag_with_drift(0.15, seed)));
    ASSERT_TRUE(trend) << "seed " << seed;
    held += std::abs(trend->per_s - 0.15 / 60.0) < trend->half_width ? 1 : 0;
    EXPECT_LT(trend->half_width, 1e-4) << "seed " << seed;
  }
  EXPECT_GE(held, 4);
}

TEST(Trend, IsNoneOfARecordWithoutOne) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) found += trend_of(task_of(lag_with_drift(0.0, seed))) ? 1 : 0;
  EXPECT_EQ(found, 0);
}

TEST(Trend, IsTakenOutWhereADriftLeavesNoModel) {
  int taken_out = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Source source = lag_with_drift(0.3, seed);
    const Identification found = identify(source, task_of(source), {}, {});
    EXPECT_FALSE(found.recommendation.model.empty()) << "seed " << seed;
    for (const IdentifiedModel& one : found.models) {
      const ident::Model& model = one.result.model;
      if (model.name != found.recommendation.model || !model.provenance.contains("trend")) continue;
      ++taken_out;
      EXPECT_FALSE(ident::takes_in_a_drift(model)) << "seed " << seed;
      EXPECT_NE(model.provenance.at("trend").find("mm/s"), std::string::npos) << model.provenance.at("trend");
      EXPECT_NE(found.warnings.back().find("a straight line of "), std::string::npos) << found.warnings.back();
    }
  }
  EXPECT_GE(taken_out, 1);
}

TEST(Trend, IsTakenOutOfRecordsThatAreCompared) {
  const Source before = lag_with_drift(0.0, 1);
  const Source after = lag_with_drift(3.0, 2);
  const RunComparison comparison = compare_runs({before, after});
  EXPECT_FALSE(comparison.runs[1].change->changed);
  EXPECT_TRUE(first_model_holds(comparison.runs[1]));
  ASSERT_FALSE(comparison.notes.empty());
  EXPECT_TRUE(comparison.notes.front().starts_with("drift.csv: the output drifts by 3 mm over the record"))
      << comparison.notes.front();
  const ScoredModel scored = score_models({comparison.runs[0].fit.model}, after).front();
  EXPECT_TRUE(scored.drift.starts_with("the output drifts by 3 mm over the record")) << scored.drift;
  EXPECT_LT(scored.rms_error, 0.006);
  EXPECT_FALSE(scored.of_another_plant);
}

TEST(Trend, IsNotThatOfASensorThatSlipped) {
  for (const double at : {0.3, 0.5, 0.7}) {
    Source slipped = lag_with_drift(0.0, 3);
    slipped.record.output.tail(static_cast<Eigen::Index>((1.0 - at) * 1200.0)).array() += 0.5;
    EXPECT_EQ(take_trend_out(slipped), "") << at;
  }
}

TEST(Trend, LeavesASoundRecordAlone) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Source source = lag_with_drift(0.0, seed);
    const Identification found = identify(source, task_of(source), {}, {});
    EXPECT_FALSE(found.recommendation.model.empty()) << "seed " << seed;
    for (const IdentifiedModel& one : found.models) {
      EXPECT_FALSE(one.result.model.provenance.contains("trend")) << "seed " << seed;
    }
  }
}

}  // namespace
}  // namespace eha::identify
