// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/fast_resonance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "ident/validation/verdict.hpp"
#include "tests/unit/ident/validation/good_model.hpp"

namespace eha::ident {
namespace {

/// Two poles of that frequency and damping.
Model swinging(double frequency_Hz, double damping) {
  Model model = good_model();
  const double w = 2.0 * std::numbers::pi * frequency_Hz;
  model.transfer_function = {{{1.0, 0.0}}, {{1.0, 0.0}, {2.0 * damping / w, 1.0}, {1.0 / (w * w), 2.0}}, 0.0};
  return model;
}

TEST(FastResonance, IsThatOfALightlyDampedPair) {
  const auto found = fastest_resonance_Hz(swinging(6.0, 0.1));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(*found, 6.0 * std::sqrt(1.0 - 0.01), 1e-6);
  EXPECT_FALSE(fastest_resonance_Hz(swinging(6.0, 0.5)));
  EXPECT_FALSE(fastest_resonance_Hz(swinging(6.0, 1.5)));
  EXPECT_NEAR(least_damping(swinging(6.0, 0.004)), 0.004, 1e-9);
  EXPECT_EQ(least_damping(swinging(6.0, 1.5)), 1.0);
  Model free_order = swinging(6.0, 0.1);
  free_order.transfer_function.denominator.back().order = 1.9;
  EXPECT_FALSE(fastest_resonance_Hz(free_order));
}

TEST(FastResonance, LowersTheVerdictAboveHalfTheNyquistFrequency) {
  RecordFacts facts;
  facts.row_s = 0.05;
  EXPECT_EQ(judge(swinging(4.9, 0.05), {}, facts).grade, Grade::good);
  const Verdict verdict = judge(swinging(6.0, 0.05), {}, facts);
  EXPECT_EQ(verdict.grade, Grade::usable);
  ASSERT_FALSE(verdict.reasons.empty());
  EXPECT_EQ(verdict.reasons.front(),
            "The resonance at 5.99 Hz is more than half the 10 Hz that rows every 0.05 s can show: one at 14 Hz looks "
            "the same in them, unless a filter before the sampling kept it out; record with rows every 0.018 s or "
            "less.");
  facts.row_s = 0.018;
  EXPECT_EQ(judge(swinging(14.0, 0.05), {}, facts).grade, Grade::usable);
  facts.row_s = 0.0178;
  EXPECT_EQ(judge(swinging(14.0, 0.05), {}, facts).grade, Grade::good);
  EXPECT_EQ(judge(swinging(14.0, 0.05), {}).grade, Grade::good) << "the rows of no record are known";
}

}  // namespace
}  // namespace eha::ident
