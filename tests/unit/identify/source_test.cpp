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
  source.interpolated_rows = 3;
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("3 of 2000 displacements (0.15 %)"), std::string::npos) << sentences[0];
}

TEST(Warnings, NameRowsOfAFileThatWereFilled) {
  Source source;
  source.name = "r.csv";
  source.record.output = Eigen::VectorXd::Zero(2000);
  source.interpolated_rows = 3;
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("3 of 2000 rows (0.15 %) were not measured and are filled"), std::string::npos);
}

TEST(Warnings, NameAnEndBeforeTime) {
  Source source;
  source.name = "runs/r";
  source.outcome = acquisition::Outcome::faulted;
  const auto sentences = warnings(source);
  ASSERT_EQ(sentences.size(), 1U);
  EXPECT_NE(sentences[0].find("runs/r did not complete (faulted)"), std::string::npos) << sentences[0];
}

}  // namespace
}  // namespace eha::identify
