// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/published_study.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>

#include "core/error.hpp"
#include "daemon/published/published_page.hpp"
#include "daemon/published/published_summary.hpp"
#include "daemon/published/set_records.hpp"
#include "daemon/published/test_start.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/model/model_output.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::published {
namespace {

constexpr double kStep_s = 0.05;
constexpr double kNoise = 0.01;

/// 2 / (0.5 s + 1), with an offset of 1.
ident::Model lag() {
  ident::Model model;
  model.name = "truth";
  model.transfer_function = {{{2.0, 0.0}}, {{0.5, 1.0}, {1.0, 0.0}}, 0.0};
  model.initial_output = 1.0;
  model.estimation.emplace();
  model.estimation->score.mse = kNoise * kNoise;
  return model;
}

ident::Record record_of(const ident::Model& model, std::uint64_t seed, Eigen::Index rows = 600) {
  ident::PortableDraw draw(seed);
  ident::Record record;
  record.step_s = kStep_s;
  record.input.resize(rows);
  double level = 0.0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (k % 10 == 0) level = 4.0 * draw.uniform() - 2.0;
    record.input[k] = level;
  }
  record.output = ident::simulate(model, record.input, kStep_s);
  for (double& y : record.output) y += kNoise * std::sqrt(12.0) * (draw.uniform() - 0.5);
  return record;
}

std::string csv_of(const ident::Record& record) {
  std::string text = "number,drive,answer\n";
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "{},{:.10g},{:.10g}\n", k, record.input[k], record.output[k]);
  }
  return text;
}

/// A set of two files, one of them in either of two forms, and a later part of the first.
PublishedSet made_up() {
  const Part first{.files = {"one.mat", "deep/one.csv"}, .input = "drive", .output = "3", .rows = 400};
  return {.name = "made-up",
          .title = "Made up",
          .what = "A lag.",
          .fetch = "nowhere",
          .period_s = kStep_s,
          .estimation = first,
          .tests = {{.name = "other record",
                     .part = {.files = {"two.csv"}, .input = "2", .output = "answer"},
                     .start_rows = 20,
                     .measure = rmse(),
                     .factor = 1000.0,
                     .unit = "mV",
                     .figures = {{"better", 1.0, "A"}, {"worse", 500.0, "B"}}},
                    {.name = "later part",
                     .part = {.files = first.files, .input = "drive", .output = "answer", .first = 400, .rows = 200},
                     .begin = Begin::continued,
                     .measure = fit_percent(),
                     .unit = "%",
                     .figures = {{"worse", 50.0, "B"}, {"better", 99.99, "A"}}}}};
}

class MadeUpSet : public testing::Test {
 protected:
  void write_both() {
    std::filesystem::create_directories(folder.path() / "some/Deep");
    folder.write("some/Deep/ONE.csv", csv_of(record_of(lag(), 1)));
    ident::Model moved = lag();
    moved.initial_state = {1.5};  // the second record does not begin at rest
    folder.write("two.csv", csv_of(record_of(moved, 2)));
  }
  StudiedSet studied() const { return study_published({&set, 1}, folder.path()).front(); }

  test::TemporaryFolder folder;
  PublishedSet set = made_up();
};

TEST_F(MadeUpSet, IsScoredInFreeRunToItsNoise) {
  write_both();
  const StudiedSet result = studied();
  ASSERT_TRUE(result.failure.empty()) << result.failure;
  EXPECT_TRUE(result.is_recommended);
  EXPECT_EQ(result.estimating_rows, 400U);
  ASSERT_EQ(result.tests.size(), 2U);
  EXPECT_EQ(result.tests[0].measured.size(), 580);
  EXPECT_NEAR(result.tests[0].score, 1000.0 * kNoise, 3.0) << result.recommendation;
  EXPECT_LE(result.tests[0].with_start_fitted.value(), result.tests[0].score);
  EXPECT_FALSE(result.tests[1].with_start_fitted);
  EXPECT_EQ(result.tests[1].measured.size(), 200);
  EXPECT_GT(result.tests[1].score, 98.0);
  EXPECT_FALSE(result.tests[1].is_of_estimating_rows);
}

TEST_F(MadeUpSet, LetsTheTestHaveNoSayInTheModel) {
  write_both();
  const StudiedSet before = studied();
  ident::Record other = record_of(lag(), 3);
  other.output *= -5.0;
  folder.write("two.csv", csv_of(other));
  const StudiedSet after = studied();
  ASSERT_TRUE(before.model && after.model);
  EXPECT_EQ(before.model->name, after.model->name);
  ASSERT_EQ(before.model->parameters.size(), after.model->parameters.size());
  for (std::size_t i = 0; i < before.model->parameters.size(); ++i) {
    EXPECT_EQ(before.model->parameters[i].value, after.model->parameters[i].value);
  }
  EXPECT_GT(after.tests[0].score, 10.0 * before.tests[0].score);
  EXPECT_EQ(after.tests[1].score, before.tests[1].score);
}

TEST_F(MadeUpSet, SaysThatARowEstimatedWhereItDid) {
  write_both();
  set.tests[1].part.first = 200;
  EXPECT_TRUE(studied().tests[1].is_of_estimating_rows);
}

TEST_F(MadeUpSet, IsScoredHoweverNoisy) {
  write_both();
  ident::Record record = record_of(lag(), 1);
  ident::PortableDraw draw(9);
  for (double& y : record.output) y += 6.0 * (draw.uniform() - 0.5);  // R2 below the limit of 90 %
  folder.write("some/Deep/ONE.csv", csv_of(record));
  const StudiedSet result = studied();
  EXPECT_FALSE(result.is_recommended);
  ASSERT_TRUE(result.model) << result.failure;
  EXPECT_LT(result.model->estimation->score.r2_percent, 90.0);
  EXPECT_NE(model_line(result).find("recommended only without the limit on R2"), std::string::npos);
  EXPECT_EQ(result.tests.size(), 2U);
}

TEST_F(MadeUpSet, IsAbsentAsLongAsOneFileIs) {
  folder.write("two.csv", csv_of(record_of(lag(), 2)));
  const StudiedSet result = studied();
  ASSERT_TRUE(result.is_absent());
  EXPECT_EQ(absence(result), "one.mat or deep/one.csv; from nowhere");
  EXPECT_FALSE(result.model);
  EXPECT_NE(page_of({result}).html.find("one.mat or deep/one.csv"), std::string::npos);
}

TEST_F(MadeUpSet, WithOtherColumnsGivesAReasonInsteadOfAScore) {
  write_both();
  folder.write("some/Deep/ONE.csv", "time_s,a,b\n0,1,2\n0.05,2,3\n0.1,1,2\n");
  const StudiedSet result = studied();
  EXPECT_NE(result.failure.find("ONE.csv: not the published file"), std::string::npos) << result.failure;
  EXPECT_TRUE(result.tests.empty());
}

TEST_F(MadeUpSet, WithTooFewRowsGivesAReasonInsteadOfAScore) {
  write_both();
  folder.write("some/Deep/ONE.csv", csv_of(record_of(lag(), 1, 300)));
  EXPECT_NE(studied().failure.find("expected at least 400 rows, got 300"), std::string::npos) << studied().failure;
}

TEST_F(MadeUpSet, RanksTheScoreByTheMeasure) {
  write_both();
  const StudiedSet result = studied();
  const auto methods = [&](const ScoredTest& scored) {
    std::string text;
    for (const Line& line : ranked(result, scored)) text += (line.is_ours ? "ours" : line.method) + " ";
    return text;
  };
  EXPECT_EQ(methods(result.tests[0]), "better ours worse ");  // the least error first
  EXPECT_EQ(methods(result.tests[1]), "better ours worse ");  // the greatest fit first
  ScoredTest diverged = result.tests[0];
  diverged.score = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(methods(diverged), "better worse ours ");
  EXPECT_NE(page_of({result}).html.find("Made up"), std::string::npos);
}

/// The record that estimated lag(): from rest.
ident::Record estimating() { return record_of(lag(), 7); }

TEST(TestStart, FindsTheStateFromTheFirstRowsAndKeepsTheOffset) {
  ident::Model moved = lag();
  moved.initial_state = {1.5};
  const ident::Record record = record_of(moved, 4);
  const ident::Model found = started(lag(), record, 40, estimating());
  ASSERT_EQ(found.initial_state.size(), 1U);
  EXPECT_NEAR(found.initial_state[0], 1.5, 0.02);
  EXPECT_EQ(found.initial_output, 1.0);
}

TEST(TestStart, IsAtRestWithoutRows) {
  ident::Model moved = lag();
  moved.initial_state = {1.5};
  EXPECT_TRUE(started(moved, record_of(moved, 4), 0, estimating()).initial_state.empty());
}

TEST(TestStart, LooksAtNoRowBeyondTheFirst) {
  ident::Record record = record_of(lag(), 5);
  const ident::Model before = started(lag(), record, 10, estimating());
  record.output.tail(record.output.size() - 10).setConstant(1e3);
  EXPECT_EQ(started(lag(), record, 10, estimating()).initial_state, before.initial_state);
}

TEST(TestStart, IsThatOfTheEstimatingRecordWhereTheRowsAreItsRows) {
  // The model errs at the start of both: its state is that of an estimate over the whole record.
  ident::Model model = lag();
  model.initial_state = {0.8};
  const ident::Record record = record_of(lag(), 5);
  const ident::Model found = started(model, record, 10, record);
  ASSERT_EQ(found.initial_state.size(), 1U);
  EXPECT_NEAR(found.initial_state[0], 0.8, 1e-9);
}

TEST(TestStart, OfAFractionalModelIsItsOffset) {
  ident::Model model = lag();
  model.transfer_function.denominator[0].order = 0.5;
  const ident::Record estimated = record_of(model, 8);
  ident::Record record = record_of(model, 6);
  record.output.array() += 3.0;
  const ident::Model found = started(model, record, 50, estimated);
  EXPECT_TRUE(found.initial_state.empty());
  EXPECT_NEAR(found.initial_output, 4.0, 0.01);
}

TEST(PublishedSets, AreWhole) {
  std::set<std::string_view> names;
  for (const PublishedSet& set : published_sets()) {
    EXPECT_TRUE(names.insert(set.name).second) << set.name;
    EXPECT_GT(set.period_s, 0.0) << set.name;
    EXPECT_FALSE(set.fetch.empty()) << set.name;
    EXPECT_FALSE(set.tests.empty()) << set.name;
    for (const published::Test& test : set.tests) {
      if (test.begin == Begin::continued) {
        EXPECT_EQ(test.part.files, set.estimation.files) << set.name;
        EXPECT_GE(test.part.first, set.estimation.first) << set.name;
        EXPECT_EQ(test.start_rows, 0U) << set.name;
      }
      for (const Figure& figure : test.figures)
        EXPECT_FALSE(figure.source.empty()) << set.name << ", " << figure.method;
    }
  }
}

TEST(FilesBelow, NamesAFolderThatIsNotThere) { EXPECT_THROW((void)files_below("/nonexistent/records"), IoError); }

}  // namespace
}  // namespace eha::published
