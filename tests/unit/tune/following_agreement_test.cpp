// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/following_agreement.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace eha::tune {
namespace {

using enum FollowingAgreement;

/// [following] of a rig that was characterised.
const config::Following kMeasured{.gain_positive_in_per_V_s = 0.074,
                                  .gain_negative_in_per_V_s = 0.065,
                                  .null_V = -0.2,
                                  .dead_band_V = 0.2,
                                  .null_uncertainty_V = 0.01,
                                  .dead_band_uncertainty_V = 0.01};

FoundMap map(double null_V, double half_width_V, double map_error_V = 0.0) {
  return {.zone = {null_V, 0.15}, .half_width = {half_width_V, half_width_V}, .map_error_V = map_error_V};
}

TEST(FollowingAgreement, HoldsForTheDifferenceThatOneValveHasBetweenSheetAndModel) {
  EXPECT_EQ(agreement_of(kMeasured, map(-0.23, 0.001)), one_valve);
  EXPECT_EQ(agreement_of(kMeasured, map(-0.249, 0.005)), other_valve);
}

TEST(FollowingAgreement, IsNotContradictedByAModelThatKnowsItsNullLessWell) {
  EXPECT_EQ(agreement_of(kMeasured, map(-0.249, 0.02)), within_interval);
  EXPECT_EQ(agreement_of(kMeasured, map(-0.272, 0.09)), within_interval);
  EXPECT_EQ(agreement_of(kMeasured, map(-0.9, 0.09)), other_valve) << "a poor record, and yet another valve";
  EXPECT_EQ(agreement_of(kMeasured, map(-0.9, std::numeric_limits<double>::infinity())), within_interval);
}

TEST(FollowingAgreement, NamesTheErrorOfTheMapWhereTheIntervalsDoNotDo) {
  EXPECT_EQ(agreement_of(kMeasured, map(-0.3, 0.01, 0.1)), within_map_error);
  EXPECT_EQ(agreement_of(kMeasured, map(-0.6, 0.01, 0.1)), other_valve);
}

TEST(FollowingAgreement, TakesTheLeastIntervalsOfAShortRecordTwice) {
  ident::Model model;
  model.input_map = ident::ValveMap{.null = -0.272, .dead_band = 0.134};
  model.parameters = {{.name = "null",
                       .value = -0.272,
                       .std = 0.024,
                       .lower95 = -0.319,
                       .upper95 = -0.225,
                       .role = ident::ParameterRole::valve_null}};
  EXPECT_NEAR(found_map(model).half_width.null_V, 0.047, 1e-12);
  model.verdict.emplace();
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::residual_input, .passed = true});
  EXPECT_NEAR(found_map(model).half_width.null_V, 0.047, 1e-12);
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::nonlinearity, .passed = false, .judged = false});
  EXPECT_NEAR(found_map(model).half_width.null_V, 0.094, 1e-12);
}

TEST(FollowingAgreement, OfASheetAndAModelFollowsTheSameRule) {
  EXPECT_TRUE(is_of_one_valve({-0.2, 0.15}, map(-0.249, 0.02)));
  EXPECT_FALSE(is_of_one_valve({-0.2, 0.15}, map(-0.249, 0.001)));
  EXPECT_TRUE(is_of_one_valve({-0.2, 0.15}, map(-0.35, 0.001, 0.1)));
}

}  // namespace
}  // namespace eha::tune
