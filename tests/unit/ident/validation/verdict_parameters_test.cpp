// SPDX-License-Identifier: GPL-3.0-or-later
// What a verdict says of parameters that a record does not determine.
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "ident/search/least_squares.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

/// A model of two free orders and one free coefficient, all of them determined.
Model identified_model() {
  Model model = good_model();
  model.parameters = {{"a2", 0.6, 0.01, 0.58, 0.62, false, ParameterRole::denominator_coefficient},
                      {"n2", 1.75, 0.15, 1.45, 2.05, false, ParameterRole::denominator_order},
                      {"n1", 0.9, 0.01, 0.88, 0.92, false, ParameterRole::denominator_order}};
  model.estimation->correlation = ParameterCorrelation{};
  model.estimation->information = InformationCriteria{};
  model.estimation->information->left_out = {{"n2", 10.0}, {"n1", 10.0}};
  return model;
}

TEST(Verdict, NamesTheOrderThatARecordDoesNotDetermine) {
  EXPECT_EQ(judge(identified_model(), {}).grade, Grade::good);
  Model model = identified_model();
  model.parameters[1].value = 2.49;
  model.parameters[1].std = 0.70;
  Verdict verdict = judge(model, {});
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict.reasons, (std::vector<std::string>{
                                 "The record hardly determines the order n2 = 2.49: its 95 % interval is +- 1.4, more "
                                 "than +- 0.29; use a model of fewer parameters, or record longer."}));
  model = identified_model();
  model.estimation->information->left_out[1].rise = -3.21;
  verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::rejected);
  EXPECT_EQ(verdict.reasons, (std::vector<std::string>{
                                 "The record does not need the term of order n1 = 0.900 +- 0.020: without it the model "
                                 "is as good (AR-BIC rises by -3.2, less than 10); use the model without it."}));
}

TEST(Verdict, RejectsACoefficientThatMayBe0) {
  Model model = identified_model();
  model.parameters[0].lower95 = 0.0;
  EXPECT_EQ(judge(model, {}).grade, Grade::rejected);
  EXPECT_EQ(judge(model, {}).reasons.front(),
            "The record does not need a2: it may be 0, its 95 % interval is 0 to 0.62; use the model without it, or "
            "record longer.");
  // A grey box has no form without one of its parameters.
  model.parameters[0].role = ParameterRole::grey_box;
  EXPECT_NE(judge(model, {}).reasons.front().find("use a transfer function (`eha fit --model ladder`)"),
            std::string::npos);
  model.parameters[0].role = ParameterRole::denominator_coefficient;
  // A coefficient that the structure or a request holds is not asked.
  model.parameters[0].fixed = true;
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
}

TEST(Verdict, CallsAModelSuperfluousOnlyWhereItDescribesTheRecordAsWell) {
  Model model = identified_model();
  model.parameters[0].lower95 = 0.0;
  EXPECT_EQ(judge(model, {}).word, kNotDetermined) << "no recommended model does as well";
  const Verdict as_well = judge(model, {}, {.error_over_recommended = 1.4});
  EXPECT_EQ(as_well.word, kNotNeeded);
  EXPECT_EQ(as_well.word, verdict_word(as_well));
  EXPECT_EQ(as_well.grade, Grade::rejected) << "as in files of before";
  EXPECT_EQ(judge(model, {}, {.error_over_recommended = 10.0}).word, "rejected");
}

TEST(Verdict, DoesNotCallACoefficientSuperfluousThatTheRecordDoesNotDetermine) {
  Model model = identified_model();
  model.parameters[0].lower95 = -std::numeric_limits<double>::infinity();
  model.parameters[0].upper95 = std::numeric_limits<double>::infinity();
  const Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.reasons.at(0),
            "The record does not determine a2 by itself: others make up for any change of it, and its 95 % interval is "
            "unbounded; simulate with it, but take no single parameter of it, or record longer.");
  EXPECT_EQ(verdict_word(verdict), kNotDetermined);
  EXPECT_FALSE(meaning_of(kNotDetermined).empty());
}

TEST(Verdict, NamesTheParametersThatCompensateEachOther) {
  Model model = good_model();
  model.estimation->termination = std::string(text(Termination::flat_ridge));
  model.estimation->correlation = ParameterCorrelation{{}, {}, {"a1", "n1"}};
  const Verdict verdict = judge(model, {});
  ASSERT_FALSE(verdict.reasons.empty());
  EXPECT_NE(verdict.reasons[0].find("Several parameters (a1, n1) compensate"), std::string::npos) << verdict.reasons[0];
}

}  // namespace
}  // namespace eha::ident
