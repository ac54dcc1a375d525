// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/command_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace eha::acquisition {
namespace {

config::RigLimits limits() {
  return {.command_min_V = -4.0, .command_max_V = 5.0, .slew_V_per_s = 50.0, .safe_V = 0.5};
}

TEST(CommandChain, StartsAtTheSafeVoltage) {
  const CommandChain chain(limits(), 0.001);
  const CommandChain::Step step = chain.plan(0.5);
  EXPECT_DOUBLE_EQ(step.command_V, 0.5);
  EXPECT_FALSE(step.clamped || step.slew_limited);
}

TEST(CommandChain, ClampsToTheRigsRangeAndSaysSo) {
  config::RigLimits fast = limits();
  fast.slew_V_per_s = 1e6;
  const CommandChain chain(fast, 0.001);
  EXPECT_DOUBLE_EQ(chain.plan(7.0).command_V, 5.0);
  EXPECT_TRUE(chain.plan(7.0).clamped);
  EXPECT_DOUBLE_EQ(chain.plan(-7.0).command_V, -4.0);
  EXPECT_TRUE(chain.plan(-7.0).clamped);
  EXPECT_FALSE(chain.plan(-4.0).clamped);
}

TEST(CommandChain, ForgetsAPlanThatWasNotWritten) {
  CommandChain chain(limits(), 0.001);
  const double first_V = chain.plan(5.0).command_V;
  EXPECT_DOUBLE_EQ(chain.plan(5.0).command_V, first_V);
  chain.accept(first_V);
  EXPECT_DOUBLE_EQ(chain.plan(5.0).command_V, first_V + 0.05);
}

TEST(CommandChain, NeverLeavesTheRangeNorExceedsTheSlewLimitWhateverIsRequested) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> request(-20.0, 20.0);
  CommandChain chain(limits(), 0.001);
  double present_V = 0.5;
  for (int k = 0; k < 100'000; ++k) {
    const CommandChain::Step step = chain.plan(request(random));
    ASSERT_LE(std::abs(step.command_V - present_V), 0.05 * (1.0 + 1e-12)) << "seed 7, step " << k;
    ASSERT_GE(step.command_V, -4.0);
    ASSERT_LE(step.command_V, 5.0);
    chain.accept(step.command_V);
    present_V = step.command_V;
  }
}

}  // namespace
}  // namespace eha::acquisition
