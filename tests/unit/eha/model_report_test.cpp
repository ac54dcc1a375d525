// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_report.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/identify/fitted_model.hpp"

namespace eha::cli {
namespace {

using identify::test::Came;
using identify::test::model_that;

TEST(ModelReport, ShowsOrdersWithTheDigitsThatTheirErrorsLeave) {
  const std::string text = model_report({model_that(Came::accepted)}, {model_that(Came::rejected)});
  EXPECT_NE(text.find("n2 1.751 +- 0.020, n0 0"), std::string::npos) << text;
  EXPECT_NE(text.find("fo (paper)"), std::string::npos) << text;
  EXPECT_NE(text.find("98.25"), std::string::npos) << text;
  EXPECT_NE(text.find("98.75"), std::string::npos) << text;
  EXPECT_NE(text.find("(0.5) / (2 s^1.75 + 1)"), std::string::npos) << text;
  EXPECT_NE(text.find("A sentence about it."), std::string::npos) << text;
}

TEST(ModelReport, GivesTheWholeOrdersOfAStructureAsNumbers) {
  auto whole = model_that(Came::accepted);
  whole.structure.structure = ident::structures::io();
  whole.result.model.transfer_function.denominator = {{2.0, 2.0}, {1.0, 1.0}, {0.5, 0.0}};
  const std::string text = model_report({whole}, {});
  EXPECT_NE(text.find(" 2, 1, 0 "), std::string::npos) << text;
  EXPECT_EQ(text.find("n2 "), std::string::npos) << text;
}

}  // namespace
}  // namespace eha::cli
