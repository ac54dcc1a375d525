// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/cross_validation_table.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha::cli {
namespace {

/// A model estimated on the second of three repetitions.
identify::CrossValidatedModel model() {
  identify::CrossValidatedModel model{.name = "io", .estimated_on = 1, .scores = {}, .offset_reestimated = {}};
  for (const double r2 : {80.0, 99.0, 90.0}) {
    model.scores.emplace_back().r2_percent = r2;
    model.offset_reestimated.emplace_back().r2_percent = r2 + 1.0;
  }
  return model;
}

TEST(CrossValidationTable, PutsTheEstimatingRepetitionInBracketsAndOutOfTheMean) {
  const std::string table = cross_validation_table({model()});
  EXPECT_NE(table.find("R2 % on 3"), std::string::npos) << table;
  EXPECT_NE(table.find("80.00    (99.00)"), std::string::npos) << table;
  EXPECT_NE(table.find("85.00     86.00"), std::string::npos) << table;
}

TEST(CrossValidationJson, CountsRepetitionsFromOne) {
  const auto json = cross_validation_json({model()});
  EXPECT_EQ(json.at(0).at("estimated_on"), 2);
  EXPECT_EQ(json.at(0).at("scores").at(1).at("estimated_here"), true);
  EXPECT_DOUBLE_EQ(json.at(0).at("others_r2_percent").get<double>(), 85.0);
  EXPECT_DOUBLE_EQ(json.at(0).at("others_r2_percent_offset_reestimated").get<double>(), 86.0);
}

}  // namespace
}  // namespace eha::cli
