// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/cross_validation.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "ident/excitation/excitation.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"

namespace eha::identify {
namespace {

constexpr double kStep_s = 0.02;
constexpr std::size_t kSamples = 500;

/// Three repetitions of a lag's noisy answer, its gain changed in the last one.
ident::Record record_whose_last_gain_is(double gain) {
  const ident::Excitation options{.kind = ident::OddRandomMultisine{.amplitude_V = 2.0, .band = {0.1, 3.0}}};
  ident::Record record;
  record.step_s = kStep_s;
  record.input = ident::excitation(options, kStep_s, kSamples).replicate(3, 1);
  record.output = ident::simulate({{{1.5, 0.0}}, {{0.2, 1.0}, {1.0, 0.0}}, 0.0}, record.input, kStep_s);
  record.output.tail(kSamples) *= gain;
  ident::PortableDraw draw(3);
  for (double& y : record.output) y += 0.01 * draw.normal();
  return record;
}

IdentificationTask task_on(const ident::Record& record, std::size_t repetition_samples = kSamples) {
  IdentificationTask task{.record = record, .source_name = "test", .repetition_samples = repetition_samples};
  task.structures.emplace_back().structure = ident::structures::io({1, 0});
  return task;
}

TEST(CrossValidation, ScoresEachRepetitionsModelOnAll) {
  const ident::Record record = record_whose_last_gain_is(1.0);
  const auto models = cross_validate(task_on(record), {});
  ASSERT_EQ(models.size(), 3U);
  for (std::size_t r = 0; r < 3; ++r) {
    EXPECT_EQ(models[r].estimated_on, r);
    ASSERT_EQ(models[r].scores.size(), 3U);
    for (const ident::Score& score : models[r].scores) {
      EXPECT_EQ(score.samples, kSamples);
      EXPECT_GT(score.r2_percent, 99.8);
    }
  }
}

TEST(CrossValidation, ShowsARepetitionThatIsUnlikeTheOthers) {
  const ident::Record record = record_whose_last_gain_is(1.5);
  const auto models = cross_validate(task_on(record), {});
  EXPECT_GT(models[0].scores[1].r2_percent, 99.8);
  // Half as much again: the error is a third of the output, R2 = 1 - 1/9.
  EXPECT_NEAR(models[0].scores[2].r2_percent, 100.0 * (1.0 - 1.0 / 9.0), 1.0);
  EXPECT_GT(models[2].scores[2].r2_percent, 99.0);
  EXPECT_NEAR(models[2].scores[0].r2_percent, 75.0, 3.0);
  EXPECT_NEAR(mean_r2_percent(models[2].scores, models[2].estimated_on), 75.0, 3.0);
}

TEST(CrossValidation, TellsWhichFitItIsAt) {
  const ident::Record record = record_whose_last_gain_is(1.0);
  std::vector<std::pair<double, std::string>> steps;
  static_cast<void>(
      cross_validate(task_on(record), [&](double share, const std::string& step) { steps.emplace_back(share, step); }));
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_DOUBLE_EQ(steps[2].first, 2.0 / 3.0);
  EXPECT_NE(steps[2].second.find("on repetition 3"), std::string::npos) << steps[2].second;
}

TEST(CrossValidation, RefusesARecordWithoutRepetitionsAndThePapersProcedure) {
  const ident::Record record = record_whose_last_gain_is(1.0);
  EXPECT_THROW(static_cast<void>(cross_validate(task_on(record, 0), {})), DataError);
  EXPECT_THROW(static_cast<void>(cross_validate(task_on(record, 2 * kSamples), {})), DataError);
  IdentificationTask task = task_on(record);
  task.options.procedure = ident::Procedure::paper;
  EXPECT_THROW(static_cast<void>(cross_validate(task, {})), UsageError);
}

}  // namespace
}  // namespace eha::identify
