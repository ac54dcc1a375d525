// SPDX-License-Identifier: GPL-3.0-or-later
// Sheets of valves that are known exactly: dead band, gains, backlash and spool in front of an integrating rod.
#include "ident/valve/valve_sheet.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

constexpr SheetLimits kLimits{
    .step_s = 0.001, .command_min_V = -5.0, .command_max_V = 5.0, .slew_V_per_s = 20.0, .travel_in = 5.6};

struct Valve {
  double null_V = -0.2;
  double dead_band_V = 0.15;
  double gain_positive = 0.148;
  double gain_negative = 0.130;
  double backlash_V = 0.0;
  double natural_frequency_Hz = 40.0;
  double damping_ratio = 0.8;
  double leakage_in_per_s = 0.0;
  double noise_in = 0.0006;
};

/// The record of a plan on a valve. Euler steps of 0.1 ms.
Record played(const SheetPlan& plan, const Valve& valve, std::uint64_t seed = 1) {
  PortableDraw draw(seed);
  Record record;
  record.step_s = kLimits.step_s;
  record.input = plan.table_V;
  record.output.resize(plan.table_V.size());
  const double w = 2.0 * std::numbers::pi * valve.natural_frequency_Hz;
  constexpr int kSteps = 10;
  const double h = kLimits.step_s / kSteps;
  double held_V = plan.table_V[0];
  double spool_V = held_V;
  double rate = 0.0;
  double place_in = 2.9;
  for (Eigen::Index k = 0; k < plan.table_V.size(); ++k) {
    record.output[k] = place_in + valve.noise_in * draw.normal();
    const double half_V = 0.5 * valve.backlash_V;
    held_V = std::clamp(held_V, plan.table_V[k] - half_V, plan.table_V[k] + half_V);
    for (int i = 0; i < kSteps; ++i) {
      rate += h * (w * w * (held_V - spool_V) - 2.0 * valve.damping_ratio * w * rate);
      spool_V += h * rate;
      const double above_V = std::max(0.0, spool_V - valve.null_V - valve.dead_band_V);
      const double below_V = std::max(0.0, valve.null_V - valve.dead_band_V - spool_V);
      place_in += h * (valve.gain_positive * above_V - valve.gain_negative * below_V + valve.leakage_in_per_s);
    }
  }
  return record;
}

SheetPlan usual_plan() { return sheet_plan(kLimits, {.null_V = 0.0, .edge_V = 0.8}); }

TEST(SheetPlan, StaysWithinRangeAndSlewAndTakesItsTime) {
  for (const double edge_V : {0.1, 0.25, 0.8}) {
    for (const double slew_V_per_s : {5.0, 20.0, 200.0}) {
      SheetLimits limits = kLimits;
      limits.slew_V_per_s = slew_V_per_s;
      const SheetPlan plan = sheet_plan(limits, {.null_V = -0.2, .edge_V = edge_V, .gain_in_per_V_s = 0.15});
      ASSERT_EQ(plan.table_V.size(), 130'000) << slew_V_per_s;
      EXPECT_LE(plan.table_V.cwiseAbs().maxCoeff(), 4.2);
      for (const SineSegment& sine : plan.sines) {
        const double steepest =
            (plan.table_V.segment(sine.first + 1, sine.rows - 1) - plan.table_V.segment(sine.first, sine.rows - 1))
                .cwiseAbs()
                .maxCoeff() /
            limits.step_s;
        EXPECT_LT(steepest, slew_V_per_s) << sine.frequency_Hz << " Hz";
        EXPECT_NEAR(plan.table_V.segment(sine.first, sine.rows).mean(), -0.2 + sine.bias_V, 1e-9)
            << "whole periods about the bias";
        EXPECT_GT(std::abs(sine.bias_V) - sine.amplitude_V, edge_V) << "clear of the dead band";
      }
    }
  }
}

TEST(SheetPlan, LeavesOutAmplitudesThatTheSlewLimitDoesNotReach) {
  SheetLimits slow = kLimits;
  slow.slew_V_per_s = 5.0;
  const SheetPlan plan = sheet_plan(slow, {.null_V = 0.0, .edge_V = 0.25});
  EXPECT_GT(plan.highest_Hz[0], 2.5);
  EXPECT_EQ(plan.highest_Hz[2], 0.0);
  EXPECT_GT(usual_plan().highest_Hz[2], 2.0);
}

TEST(SheetPlan, MovesAQuickRodInShorterTriangles) {
  const SheetPlan slow = sheet_plan(kLimits, {.edge_V = 0.2, .gain_in_per_V_s = 0.1});
  const SheetPlan quick = sheet_plan(kLimits, {.edge_V = 0.2, .gain_in_per_V_s = 1.5});
  const auto crossings = [](const SheetPlan& plan) {
    int count = 0;
    for (Eigen::Index k = plan.sweep_first + 1; k < plan.sweep_first + plan.sweep_rows; ++k) {
      count += plan.table_V[k] > 0.0 && plan.table_V[k - 1] <= 0.0 ? 1 : 0;
    }
    return count;
  };
  EXPECT_EQ(crossings(slow), 3);
  EXPECT_GT(crossings(quick), 6);
}

TEST(ValveSheet, RecoversAKnownValve) {
  const SheetPlan plan = usual_plan();
  for (const double null_V : {-0.35, -0.2, 0.3}) {
    for (const double dead_band_V : {0.05, 0.15, 0.4}) {
      Valve valve;
      valve.null_V = null_V;
      valve.dead_band_V = dead_band_V;
      valve.noise_in = 0.0002;
      const ValveSheet sheet = valve_sheet(played(plan, valve), plan);
      EXPECT_NEAR(sheet.null_V.value, null_V, 0.004);
      EXPECT_NEAR(sheet.dead_band_V.value, dead_band_V, 0.004);
      EXPECT_NEAR(sheet.gain_positive_in_per_V_s.value, 0.148, 0.001);
      EXPECT_NEAR(sheet.gain_negative_in_per_V_s.value, 0.130, 0.001);
      EXPECT_FALSE(sheet.has_hysteresis) << sheet.hysteresis_V.value;
      EXPECT_NEAR(sheet.noise_in, 0.0002, 0.00002);
    }
  }
}

TEST(ValveSheet, PartsLeakageFromTheNull) {
  const SheetPlan plan = usual_plan();
  Valve valve;
  valve.leakage_in_per_s = 0.003;  // 20 mV of the edges
  const ValveSheet sheet = valve_sheet(played(plan, valve), plan);
  EXPECT_NEAR(sheet.null_V.value, valve.null_V, 0.005);
  EXPECT_NEAR(sheet.dead_band_V.value, valve.dead_band_V, 0.005);
  ASSERT_TRUE(sheet.creep_in_per_s.has_value());
  EXPECT_NEAR(sheet.creep_in_per_s->value, 0.003, 2.0 * sheet.creep_in_per_s->half_width);
}

TEST(ValveSheet, ClaimsHysteresisOnlyWhereThereIsSome) {
  const SheetPlan plan = usual_plan();
  for (const double backlash_V : {0.02, 0.05, 0.1}) {
    Valve valve;
    valve.backlash_V = backlash_V;
    const ValveSheet sheet = valve_sheet(played(plan, valve), plan);
    EXPECT_TRUE(sheet.has_hysteresis) << backlash_V;
    EXPECT_NEAR(sheet.hysteresis_V.value, backlash_V, 0.006);
    EXPECT_NEAR(sheet.null_V.value, valve.null_V, 0.004) << "the null lies between rising and falling";
  }
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ValveSheet sheet = valve_sheet(played(plan, Valve{}, seed), plan);
    EXPECT_FALSE(sheet.has_hysteresis) << "seed " << seed << ": " << sheet.hysteresis_V.value;
  }
}

TEST(ValveSheet, ObservesASlowValvesResponse) {
  const SheetPlan plan = usual_plan();
  Valve valve;
  valve.natural_frequency_Hz = 6.0;
  valve.damping_ratio = 0.6;
  const ValveSheet sheet = valve_sheet(played(plan, valve), plan);
  ASSERT_EQ(sheet.responses.size(), 3U);
  const AmplitudeResponse& small = sheet.responses[0];
  ASSERT_TRUE(small.minus_3dB_Hz && small.minus_90deg_Hz);
  // (1 - r^2)^2 + (2 zeta r)^2 = 2, r = f / 6 Hz
  const double x = 1.0 - 2.0 * 0.36;
  EXPECT_NEAR(small.minus_3dB_Hz->value, 6.0 * std::sqrt(x + std::sqrt(x * x + 1.0)), 0.2);
  EXPECT_NEAR(small.minus_90deg_Hz->value, 6.0, 0.2);
  EXPECT_FALSE(sheet.responses[2].minus_3dB_Hz.has_value()) << "25 % was played up to 2.3 Hz only";
  ASSERT_TRUE(sheet.natural_frequency_Hz && sheet.damping_ratio);
  EXPECT_NEAR(sheet.natural_frequency_Hz->value, 6.0, std::max(0.15, sheet.natural_frequency_Hz->half_width));
  EXPECT_NEAR(sheet.damping_ratio->value, 0.6, std::max(0.03, sheet.damping_ratio->half_width));
  EXPECT_NEAR(sheet.lag_s, 1.2 / (2.0 * std::numbers::pi * 6.0), 0.003);
}

TEST(ValveSheet, SaysWhatItDidNotObserve) {
  const SheetPlan plan = usual_plan();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const ValveSheet sheet = valve_sheet(played(plan, Valve{}, seed), plan);
    for (const AmplitudeResponse& response : sheet.responses) {
      EXPECT_TRUE(response.is_played);
      EXPECT_FALSE(response.minus_3dB_Hz || response.minus_90deg_Hz);
    }
    EXPECT_FALSE(sheet.natural_frequency_Hz || sheet.damping_ratio) << "a valve of 40 Hz, played up to 12 Hz";
  }
}

TEST(ValveSheet, LeavesOutSinesThatEnterTheDeadBand) {
  // The null has moved since [following] was written: the sines above it reach into the dead band.
  const SheetPlan plan = sheet_plan(kLimits, {.null_V = -0.2, .edge_V = 0.25});
  Valve valve;
  valve.null_V = 0.1;
  const ValveSheet sheet = valve_sheet(played(plan, valve), plan);
  EXPECT_NEAR(sheet.null_V.value, 0.1, 0.004);
  ASSERT_FALSE(sheet.responses[0].points.empty()) << "those below it remain";
  for (const ResponsePoint& point : sheet.responses[0].points) EXPECT_NEAR(point.gain_dB, 0.0, 1.0);
}

std::string refusal(const Record& record, const SheetPlan& plan) {
  try {
    static_cast<void>(valve_sheet(record, plan));
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(ValveSheet, RefusesARodThatStandsOrGoesTheWrongWay) {
  const SheetPlan plan = usual_plan();
  Valve stuck;
  stuck.gain_positive = 0.0;
  stuck.gain_negative = 0.0;
  EXPECT_NE(refusal(played(plan, stuck), plan).find("the record does not determine the valve"), std::string::npos);
  Valve reversed;
  reversed.gain_positive = -0.148;
  reversed.gain_negative = -0.130;
  EXPECT_NE(refusal(played(plan, reversed), plan), "");
  Valve wide;
  wide.dead_band_V = 2.0;
  EXPECT_NE(refusal(played(plan, wide), plan).find("[following]"), std::string::npos);
  Record cut = played(plan, Valve{});
  cut.output.conservativeResize(40'000);
  cut.input.conservativeResize(40'000);
  EXPECT_NE(refusal(cut, plan).find("40000 rows"), std::string::npos);
}

}  // namespace
}  // namespace eha::ident
