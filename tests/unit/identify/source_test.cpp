// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/source.hpp"

#include <gtest/gtest.h>

namespace eha::identify {
namespace {

TEST(Warnings, NameRowsThatWereNotMeasured) {
  Source source;
  source.name = "runs/latest";
  source.run_folder = "runs/latest";
  source.record.output = Eigen::VectorXd::Zero(2000);
  EXPECT_TRUE(warnings(source).empty());
  source.unmeasured = {.rows = 3, .in_gaps = 0, .of_rows = 2000};
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("3 of 2000 displacements (0.15 %)"), std::string::npos) << sentences[0];
}

TEST(Warnings, NameRowsOfAFileThatWereNotMeasured) {
  Source source;
  source.name = "r.csv";
  source.record.output = Eigen::VectorXd::Zero(2000);
  source.unmeasured = {.rows = 3, .in_gaps = 0, .of_rows = 2000};
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_EQ(sentences[0], "3 of 2000 rows (0.15 %) were not measured and count for nothing in fit and tests");
  source.unmeasured.without_input = 2;
  EXPECT_EQ(warnings(source)[0],
            sentences[0] +
                "; in 2 the input is missing: it is taken as straight from row to row, in gaps of 5 rows or more as "
                "held, and where it switched there, the figures are less exact than their intervals say");
}

TEST(Warnings, NameAnEndBeforeTime) {
  Source source;
  source.name = "runs/r";
  source.outcome = acquisition::Outcome::faulted;
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("runs/r did not complete (faulted)"), std::string::npos) << sentences[0];
}

TEST(Warnings, OfSeveralSourcesCarryTheirNames) {
  Source first;
  first.name = "a.csv";
  first.record.output = Eigen::VectorXd::Zero(2000);
  first.unmeasured = {.rows = 3, .in_gaps = 0, .of_rows = 2000};
  Source second = first;
  second.name = "b.csv";
  second.unmeasured = {};
  second.remarks = {"b.csv: the output rests", "the unit \"v\" is none"};
  const auto sentences = named_warnings({first, second});
  ASSERT_EQ(sentences.size(), 3U);
  EXPECT_TRUE(sentences[0].starts_with("a.csv: 3 of 2000 rows")) << sentences[0];
  EXPECT_EQ(sentences[1], "b.csv: the output rests");
  EXPECT_EQ(sentences[2], "b.csv: the unit \"v\" is none");
}

}  // namespace
}  // namespace eha::identify
