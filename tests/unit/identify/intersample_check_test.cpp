// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/intersample_check.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"

namespace eha::identify {
namespace {

constexpr int kFineParts = 10;  // samples of a row
constexpr Eigen::Index kSampledRows = 800;
constexpr double kRowStep_s = 0.05;

enum class Input { sampled, staircase };

/// A lag behind an input that moves all the time, or is held for a row; rows come up to four samples late.
Source source_of(Input kind, int late_parts = 0) {
  Eigen::VectorXd input(kFineParts * (kSampledRows + 1));
  for (Eigen::Index k = 0; k < input.size(); ++k) {
    const double t = kRowStep_s / kFineParts * static_cast<double>(kind == Input::sampled ? k : k - k % kFineParts);
    input[k] = std::sin(1.1 * t) + std::sin(4.3 * t + 1.0);
  }
  const double delay_s = late_parts * kRowStep_s / kFineParts;
  const Eigen::VectorXd output =
      ident::simulate({{{1.5, 0.0}}, {{0.3, 1.0}, {1.0, 0.0}}, delay_s}, input, kRowStep_s / kFineParts);
  Source source;
  source.name = "rows.csv";
  source.record.step_s = kRowStep_s;
  source.record.input.resize(kSampledRows);
  source.record.output.resize(kSampledRows);
  ident::PortableDraw draw(5);
  for (Eigen::Index k = 0; k < kSampledRows; ++k) {
    const double late = kind == Input::sampled ? 0.0 : std::round(4.0 * std::tanh(draw.normal()));
    const Eigen::Index at = std::max<Eigen::Index>(0, kFineParts * k + static_cast<Eigen::Index>(late));
    source.record.input[k] = input[at];
    source.record.output[k] = output[at] + 0.002 * draw.normal();
  }
  return source;
}

std::optional<BetweenRows> found_on(const Source& source, ident::Freedom delay = ident::Freedom::held) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "lag";
  structure.structure = ident::structures::io({1, 0});
  structure.structure.delay.freedom = delay;
  task.structures.push_back(structure);
  return input_between_rows(source, task, identify(source, task, {}, {}));
}

std::string advice_on(const Source& source, ident::Freedom delay = ident::Freedom::held) {
  const auto found = found_on(source, delay);
  return found ? advice_of(*found, "eha fit rows.csv --intersample foh") : std::string();
}

TEST(IntersampleAdvice, OffersStraightLinesForASignalThatWasSampled) {
  EXPECT_NE(advice_on(source_of(Input::sampled)).find("falls from"), std::string::npos);
}

TEST(InputBetweenRows, IsStraightWhereTheErrorFallsFarByThatAlone) {
  const auto sampled = found_on(source_of(Input::sampled));
  ASSERT_TRUE(sampled);
  EXPECT_TRUE(sampled->is_straight) << sampled->seen;
  // A dead time of ten rows, which the structure lacks, is none of the rows' halves.
  const auto held = found_on(source_of(Input::staircase, 100));
  EXPECT_FALSE(held && held->is_straight) << held->seen;
}

TEST(InputBetweenRows, IsStraightForSeveralFilesTogetherOrForNone) {
  const auto together = [](const std::vector<Source>& sources) {
    std::vector<ident::Model> models;
    for (const Source& source : sources) {
      ident::StructureOptions lag{.name = "lag", .structure = ident::structures::io({1, 0})};
      models.push_back(ident::fit(source.record, lag, {}, ident::run_in_order).model);
    }
    std::vector<const ident::Model*> each;
    for (const ident::Model& model : models) each.push_back(&model);
    return are_straight(sources, each);
  };
  EXPECT_TRUE(together({source_of(Input::sampled), source_of(Input::sampled)}));
  EXPECT_FALSE(together({source_of(Input::staircase), source_of(Input::staircase)}));
  Source run = source_of(Input::sampled);
  run.run_folder = "runs/one";
  EXPECT_FALSE(together({run, run})) << "a run's input is held";
}

TEST(IntersampleAdvice, SaysThatALagMayHoldHalfARow) {
  Source noisy = source_of(Input::sampled);
  ident::PortableDraw draw(11);
  for (double& y : noisy.record.output) y += 0.2 * draw.normal();
  EXPECT_NE(advice_on(noisy).find("its lags together are 25 ms (half a row) longer"), std::string::npos)
      << advice_on(noisy);
  Source coarse = noisy;  // as of an oscilloscope, whose codes repeat
  for (double& u : coarse.record.input) u = 0.1 * std::round(10.0 * u);
  EXPECT_NE(advice_on(coarse), "");
}

TEST(IntersampleAdvice, SaysThatADeadTimeMayLackHalfARow) {
  const std::string advice = advice_on(source_of(Input::sampled, 12), ident::Freedom::free);
  EXPECT_NE(advice.find("half a row longer"), std::string::npos) << advice;
  EXPECT_NE(advice.find(" + 25 ms"), std::string::npos) << advice;
  EXPECT_EQ(advice_on(source_of(Input::staircase, 12), ident::Freedom::free), "");
  EXPECT_NE(advice.find("--intersample foh"), std::string::npos) << advice;
}

TEST(IntersampleAdvice, OffersNoStraightLinesForAStaircaseWhoseRowsWereMoved) {
  EXPECT_EQ(advice_on(source_of(Input::staircase)), "");
}

}  // namespace
}  // namespace eha::identify
