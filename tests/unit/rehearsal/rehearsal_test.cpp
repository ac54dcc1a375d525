// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rehearsal/rehearsal.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <string>

#include "config/measured_check.hpp"
#include "config/valve_estimate.hpp"
#include "daemon/acquisition/limit_monitor.hpp"

namespace eha {
namespace {

const config::RigConfig& sim() {
  static const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  return rig;
}

config::PreparedExperiment sine(double offset_V, const std::string& more = "", double duration_s = 60.0) {
  const std::string text = fmt::format(
      "schema = 1\nname = \"s\"\nduration_s = {:.1f}\n[excitation]\nkind = \"sine\"\noffset_V = {:.4f}\n"
      "tones = [{{ frequency_Hz = 0.2, amplitude_V = 2.0 }}]\n[record]\ndiscard_s = 0.0\n{}",
      duration_s, offset_V, more);
  return config::parse_prepared_experiment(text, "s.toml", sim());
}

/// Where a rod on this valve goes in the first 30 s of an experiment [in].
Eigen::VectorXd moved_by(const config::ValveEstimate& valve, const config::PreparedExperiment& experiment) {
  Eigen::VectorXd displacement(30'000);
  double place_in = 2.95;
  for (Eigen::Index k = 0; k < displacement.size(); ++k) {
    displacement[k] = place_in;
    place_in += 0.001 * valve.velocity_in_per_s(experiment.table_V[k]);
  }
  return displacement;
}

/// The offset at which the shipped rig's valve makes no drift of the sine.
double balanced_V() {
  const config::PreparedExperiment any = sine(-0.2);
  return drift_of(any, sim(), moved_by(config::valve_estimate(*sim().limits.following), any))->offset_V.value_or(9.0);
}

TEST(Rehearsal, SaysThatABalancedSineStaysInsideAndAnOffsetOneDoesNot) {
  const auto good = rehearse(sine(balanced_V()), sim(), 2.95);
  ASSERT_TRUE(good.has_value());
  EXPECT_LT(good->chance_of_trip, 0.05);
  EXPECT_NEAR(good->drift_in_per_s, 0.0, 1e-3);
  EXPECT_GT(good->lowest_in, 1.0);
  EXPECT_LT(good->highest_in, 5.0);
  const auto bad = rehearse(sine(balanced_V() + 0.6), sim(), 2.95);
  EXPECT_GT(bad->chance_of_trip, 0.95);
  EXPECT_GT(bad->drift_in_per_s, 0.05);
}

/// Of offsets 0.01 V apart, those at which the rod may or may not reach the limit in 60 s.
int undecided_offsets(const config::RigConfig& rig) {
  int undecided = 0;
  for (int i = 0; i <= 40; ++i) {
    const double chance = rehearse(sine(balanced_V() + 0.2 + 0.01 * i), rig, 2.95)->chance_of_trip;
    undecided += chance > 0.05 && chance < 0.95 ? 1 : 0;
  }
  return undecided;
}

TEST(Rehearsal, IsAsUncertainWhereTheNullDecidesAsTheRigFileSaysOfTheNull) {
  config::RigConfig rig = sim();
  config::Following& following = rig.limits.following.value();
  following.null_uncertainty_V = 0.04;
  following.dead_band_uncertainty_V = 0.04;
  following.gain_uncertainty_percent = 6.0;
  const int rough = undecided_offsets(rig);
  EXPECT_GE(rough, 3);
  EXPECT_LE(rough, 16);
  following.null_uncertainty_V = 0.01;
  following.dead_band_uncertainty_V = 0.01;
  following.gain_uncertainty_percent = 1.5;
  EXPECT_LT(undecided_offsets(rig), (rough + 1) / 2);
}

TEST(Rehearsal, AssumesAnUncertaintyWhereTheRigFileGivesNone) {
  config::Following following = sim().limits.following.value();
  following.null_uncertainty_V = 0.0098;
  following.dead_band_uncertainty_V.reset();
  following.gain_uncertainty_percent.reset();
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(following);
  EXPECT_NEAR(uncertainty.null_V, 0.005, 1e-12);
  EXPECT_EQ(uncertainty.dead_band_V, 0.02);
  EXPECT_EQ(uncertainty.gain_share, 0.03);
}

TEST(Rehearsal, KnowsThatAHoldTakesTheDriftAway) {
  const auto held = rehearse(sine(balanced_V() + 0.6, "[hold]\n"), sim(), 2.95);
  ASSERT_TRUE(held.has_value());
  EXPECT_LT(held->chance_of_trip, 0.05);
  EXPECT_EQ(held->drift_in_per_s, 0.0);
}

TEST(Rehearsal, SeesWhatATablePlaysBetweenItsSteps) {
  config::RigConfig rig = sim();
  rig.limits.slew_V_per_s = 1000.0;
  config::PreparedExperiment experiment = sine(balanced_V(), "", 30.0);
  for (Eigen::Index k = 0; k < experiment.table_V.size(); ++k) experiment.table_V[k] = k % 5 == 0 ? -0.2 : 0.78;
  const auto seen = rehearse(experiment, rig, 2.95);
  ASSERT_TRUE(seen.has_value());
  const double valve_in = moved_by(config::valve_estimate(*rig.limits.following), experiment)[29'999] - 2.95;
  EXPECT_GT(valve_in, 0.5);
  EXPECT_NEAR(seen->highest_in - 2.95, valve_in, 0.3 * valve_in);
}

TEST(Rehearsal, BeginsAtTheStartOfTheExperiment) {
  const auto started = rehearse(sine(balanced_V(), "[start]\ndisplacement_in = 1.5\n"), sim(), 5.0);
  EXPECT_LT(started->highest_in, 4.0);
}

/// The first volts are reached, and left after the last row, at the slew limit: with a low one the rod goes a long way.
TEST(Rehearsal, PlaysTheRampsBeforeAndAfterTheTable) {
  config::RigConfig rig = sim();
  rig.limits.slew_V_per_s = 2.6;
  const config::PreparedExperiment steady = config::parse_prepared_experiment(
      "schema = 1\nname = \"s\"\nduration_s = 2.9\n[excitation]\nkind = \"sine\"\noffset_V = 4.3\n"
      "tones = [{ frequency_Hz = 0.2, amplitude_V = 1e-6 }]\n[record]\ndiscard_s = 0.0\n",
      "s.toml", rig);
  const auto found = rehearse(steady, rig, 2.0);
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const double open_V = 4.3 - valve.null_V - valve.dead_band_V;
  const double speed = valve.velocity_in_per_s(4.3);
  const double ramp_in = 0.5 * speed * open_V / 2.6;
  EXPECT_NEAR(found->highest_in, 2.0 + 2.9 * speed + 2.0 * ramp_in, 0.15);
  EXPECT_GT(rehearse(steady, rig, 2.95)->chance_of_trip, 0.95);
}

TEST(Rehearsal, BeginsBehindThePlacingThatShowsARodByNumbersThatNobodyMeasured) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  ASSERT_TRUE(config::shows_motion_first(rig));
  const config::PreparedExperiment experiment = sine(balanced_V(), "", 10.0);  // ends before a limit
  const auto shown = rehearse(experiment, rig, 2.0);
  rig.limits.following->measured_check = config::measured_check_of(*rig.limits.following);
  rig.limits.following->measured_rig_check = config::measured_rig_check_of(rig.backend);
  const auto measured = rehearse(experiment, rig, 2.0);
  ASSERT_TRUE(shown && measured);
  EXPECT_NEAR(shown->highest_in - measured->highest_in, 0.15, 0.02);
  EXPECT_NEAR(shown->lowest_in - measured->lowest_in, 0.15, 0.02);
}

TEST(Rehearsal, IsNoneWithoutTheValveAndForAPlacing) {
  config::RigConfig unknown = sim();
  unknown.limits.following.reset();
  EXPECT_FALSE(rehearse(sine(-0.2), unknown, 2.95).has_value());
  const auto placing = config::parse_prepared_experiment(
      "schema = 1\nname = \"g\"\nduration_s = 60.0\n[place]\ndisplacement_in = 3.0\n", "g.toml", sim());
  EXPECT_FALSE(rehearse(placing, sim(), 2.95).has_value());
}

TEST(Rehearsal, DoesNotAdviseTheOffsetThatStopsAStepItself) {
  const config::PreparedExperiment step = config::parse_prepared_experiment(
      "schema = 1\nname = \"s\"\nduration_s = 6.0\n[excitation]\nkind = \"step\"\noffset_V = -0.2\namplitude_V = 3.0\n"
      "hold_s = 1.0\n[record]\ndiscard_s = 0.0\n",
      "s.toml", sim());
  const auto found = rehearse(step, sim(), 2.0);
  ASSERT_TRUE(found);
  EXPECT_GT(found->drift_in_per_s, 0.1);
  EXPECT_FALSE(found->still_offset_V) << *found->still_offset_V;
  EXPECT_FALSE(drift_of(step, sim(), Eigen::VectorXd::LinSpaced(6000, 2.0, 4.0)));
}

TEST(Drift, NamesTheOffsetThatStopsIt) {
  const config::ValveEstimate valve = config::valve_estimate(*sim().limits.following);
  // The rod's valve has its null 0.1 V away from where the file has it.
  config::ValveEstimate true_valve = valve;
  true_valve.null_V -= 0.1;
  const config::PreparedExperiment played = sine(-0.2);
  const Eigen::VectorXd displacement = moved_by(true_valve, played);
  const auto drift = drift_of(played, sim(), displacement);
  ASSERT_TRUE(drift && drift->offset_V);
  EXPECT_NEAR(drift->rate_in_per_s, (displacement[29'999] - 2.95) / 30.0, 1e-3);
  EXPECT_NEAR(*drift->offset_V, balanced_V() - 0.1, 0.01);
}

/// The lowest upper travel limit that does not trip, to 0.001 in.
double lowest_free_limit(const std::function<bool(double)>& trips) {
  double low_in = 1.5;
  double high_in = 5.0;
  while (high_in - low_in > 0.001) {
    const double middle_in = 0.5 * (low_in + high_in);
    (trips(middle_in) ? low_in : high_in) = middle_in;
  }
  return high_in;
}

TEST(Rehearsal, TripsWhereTheMonitorTripsAtEveryTick) {
  for (const double tick_s : {0.0002, 0.001, 0.004, 0.01, 0.05}) {
    for (const double speed : {0.2, 2.0, 4.0}) {
      config::RigConfig rig = sim();
      rig.realtime.sample_period_s = tick_s;
      rig.limits.slew_V_per_s = 1e6;  // the rod below has its speed at once
      rig.limits.following = config::Following{.gain_positive_in_per_V_s = 0.5,
                                               .gain_negative_in_per_V_s = 0.5,
                                               .null_V = 0.0,
                                               .dead_band_V = config::kDeadBandSpare_V,
                                               .null_uncertainty_V = 0.0,
                                               .dead_band_uncertainty_V = 0.0,
                                               .gain_uncertainty_percent = 0.0};
      // One inch upwards at that speed, and then at rest. The valve gives 1 in/s for each volt.
      const auto moving = static_cast<Eigen::Index>(std::llround(1.0 / speed / tick_s));
      const auto resting = static_cast<Eigen::Index>(std::llround(0.2 / tick_s));
      config::PreparedExperiment experiment = sine(0.0);
      experiment.table_V.setZero(moving + resting);
      experiment.table_V.head(moving).setConstant(speed);
      const double rehearsed_in = lowest_free_limit([&](double limit_in) {
        rig.limits.travel_max_in = limit_in;
        return rehearse(experiment, rig, 1.0)->chance_of_trip > 0.5;
      });
      const double monitored_in = lowest_free_limit([&](double limit_in) {
        rig.limits.travel_max_in = limit_in;
        acquisition::LimitMonitor monitor(rig.limits, tick_s);
        double place_in = 1.0;
        bool trips = false;
        for (Eigen::Index k = 0; k < experiment.table_V.size() && !trips; ++k) {
          const hal::RigReading reading{.displacement_in = place_in,
                                        .feedback_code = static_cast<std::uint32_t>(k % 2)};
          trips = monitor.check(std::llround(1e9 * tick_s * static_cast<double>(k)), reading, 0.0).fault !=
                  acquisition::Fault::none;
          place_in += tick_s * experiment.table_V[k];
        }
        return trips;
      });
      EXPECT_NEAR(rehearsed_in, monitored_in, 0.01) << "tick " << tick_s << " s, " << speed << " in/s";
    }
  }
}

}  // namespace
}  // namespace eha
