// SPDX-License-Identifier: GPL-3.0-or-later
// Intervals of parameters that a record says little or nothing of.
#include "ident/uncertainty/profile.hpp"

#include <gtest/gtest.h>

#include "ident/estimation/fit.hpp"
#include "ident/structure/order_bounds.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

// An interval takes at most 28 local fits of 60 simulations; a fit of two orders ends far below that.
constexpr std::size_t kMostEvaluations = 12'000;

TEST(Intervals, StayWithinTheBoundsOfTheSearchWhereARecordSaysNothingOfAnOrder) {
  // One pole: of two orders one has no effect, and its linear standard error is of any size.
  Model lag;
  lag.transfer_function = {{{1.0, 0.0}}, {{1.0, 1.0}, {1.5, 0.0}}, 0.0};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Model model = fit(record_of(lag, 0.05, 0.01, seed), asked_for(structures::fo()), {}).model;
    EXPECT_LE(model.estimation->evaluations, kMostEvaluations) << "seed " << seed;
    for (const ParameterEstimate& p : model.parameters) {
      if (p.fixed || !is_order(p.role)) continue;
      EXPECT_GE(p.lower95, kLowestOrder) << p.name << ", seed " << seed;
      EXPECT_LE(p.upper95, kHighestOrder) << p.name << ", seed " << seed;
      EXPECT_LE(p.lower95, p.value) << p.name << ", seed " << seed;
      EXPECT_GE(p.upper95, p.value) << p.name << ", seed " << seed;
    }
  }
}

TEST(Intervals, OfACoefficientThatMayBeAbsentReachDownTo0) {
  Model lag;
  lag.transfer_function = {{{1.0, 0.0}}, {{1.0, 1.0}, {1.5, 0.0}}, 0.0};
  const Model model = fit(record_of(lag, 0.05, 0.02, 3), asked_for(structures::io()), {}).model;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.name != "a2") continue;
    EXPECT_EQ(p.lower95, 0.0);
    EXPECT_GT(p.upper95, p.value);
  }
}

}  // namespace
}  // namespace eha::ident
