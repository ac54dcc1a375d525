// SPDX-License-Identifier: GPL-3.0-or-later
// The valve sheet of simulated rigs whose valve is known, without and with what their rig file says of it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "tests/unit/place/characterised_rig.hpp"

namespace eha::place {
namespace {

config::RigConfig rig_without_following() {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  rig.limits.following.reset();
  return rig;
}

/// A rig within the range that the sheet is promised for.
hal::SimOptions perturbed(const config::RigConfig& rig, ident::PortableDraw& draw) {
  const auto between = [&](double low, double high) { return low + (high - low) * draw.uniform(); };
  auto options = std::get<hal::SimOptions>(rig.backend);
  options.valve_null_offset_V = between(-0.4, 0.4);
  options.valve_dead_band_V = between(0.05, 0.4);
  options.rod_mm = between(16.0, 28.0);
  options.seed = 1 + draw.below(1'000'000);
  return options;
}

/// Speed of a rig's rod at a constant command, once the pressures have settled [in/s].
double settled_speed(hal::SimOptions options, double command_V) {
  options.initial_displacement_in = command_V > 0.0 ? 1.0 : 4.9;
  options.sensor_noise_V = 0.0;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(options, 0.0);
  hal::AppliedCommand applied;
  hal::RigReading first;
  hal::RigReading last;
  rig->command(command_V, applied);
  rig->set_enable(true);
  for (int k = 0; k <= 8000; ++k) rig->read(static_cast<std::int64_t>(k) * 1'000'000, k <= 4000 ? first : last);
  return (last.displacement_in - first.displacement_in) / 4.0;
}

/// The gain between 0.4 and 1.2 V outside the dead band.
double true_gain(const hal::SimOptions& options, double direction) {
  const double edge_V = -options.valve_null_offset_V + direction * options.valve_dead_band_V;
  return (settled_speed(options, edge_V + direction * 1.2) - settled_speed(options, edge_V + direction * 0.4)) /
         (direction * 0.8);
}

struct Truth {
  double null_V;
  double dead_band_V;
  double gain_positive;
  double gain_negative;
};

Truth truth_of(const hal::SimOptions& options) {
  return {.null_V = -options.valve_null_offset_V,
          .dead_band_V = options.valve_dead_band_V,
          .gain_positive = true_gain(options, 1.0),
          .gain_negative = true_gain(options, -1.0)};
}

bool covers(const ident::Measured& measured, double truth) {
  return std::abs(measured.value - truth) <= measured.half_width;
}

TEST(CharacteriseCampaign, FindsTheValvesOfTwentyPerturbedRigsThatNothingIsKnownOf) {
  const config::RigConfig rig = rig_without_following();
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  ident::PortableDraw draw(5);
  double worst_V = 0.0;
  double worst_gain = 0.0;
  for (int i = 0; i < 20; ++i) {
    const hal::SimOptions options = perturbed(rig, draw);
    const Truth truth = truth_of(options);
    const std::string which = fmt::format("rig {}: null {:.3f} V, dead band {:.3f} V, rod {:.1f} mm", i, truth.null_V,
                                          truth.dead_band_V, options.rod_mm);
    const CharacterisedRig played = characterised(rig, options);
    ASSERT_TRUE(played.is_in_place) << which;
    EXPECT_FALSE(played.trips_following) << which;
    EXPECT_LE(played.taken_s, 360.0) << which;
    EXPECT_GT(played.lowest_in, rig.limits.travel_min_in + 0.5) << which;
    EXPECT_LT(played.highest_in, rig.limits.travel_max_in - 0.5) << which;
    const ident::ValveSheet sheet = ident::valve_sheet(played.record, plan);
    EXPECT_NEAR(sheet.null_V.value, truth.null_V, 0.01) << which;
    EXPECT_NEAR(sheet.dead_band_V.value, truth.dead_band_V, 0.01) << which;
    EXPECT_NEAR(sheet.gain_positive_in_per_V_s.value / truth.gain_positive, 1.0, 0.025) << which;
    EXPECT_NEAR(sheet.gain_negative_in_per_V_s.value / truth.gain_negative, 1.0, 0.025) << which;
    EXPECT_FALSE(sheet.has_hysteresis) << which << ", " << sheet.hysteresis_V.value << " V";
    EXPECT_FALSE(sheet.natural_frequency_Hz.has_value()) << which << ", spool of 40 Hz, played up to 12 Hz";
    worst_V = std::max(
        {worst_V, std::abs(sheet.null_V.value - truth.null_V), std::abs(sheet.dead_band_V.value - truth.dead_band_V)});
    worst_gain = std::max({worst_gain, std::abs(sheet.gain_positive_in_per_V_s.value / truth.gain_positive - 1.0),
                           std::abs(sheet.gain_negative_in_per_V_s.value / truth.gain_negative - 1.0)});
  }
  fmt::print("null and dead band within {:.1f} mV, gains within {:.2f} %\n", 1e3 * worst_V, 100.0 * worst_gain);
}

/// The rig's simulated cylinder with a valve of so many times the flow.
hal::SimOptions with_flow(const config::RigConfig& rig, double times) {
  auto options = std::get<hal::SimOptions>(rig.backend);
  options.valve_rated_flow_L_per_min *= times;
  while (!hal::check(options).empty() && options.sub_step_us > 10.0) options.sub_step_us -= 2.0;
  return options;
}

TEST(CharacteriseCampaign, FindsTheValveOfAFastRodThatNothingIsKnownOf) {
  const config::RigConfig rig = rig_without_following();
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  for (const double times : {3.0, 7.0}) {
    const hal::SimOptions options = with_flow(rig, times);
    const CharacterisedRig played = characterised(rig, options);
    ASSERT_TRUE(played.is_in_place) << times;
    EXPECT_FALSE(played.trips_following) << times;
    const ident::ValveSheet sheet = ident::valve_sheet(played.record, plan);
    fmt::print("{} times the flow: null {:.4f} V, dead band {:.4f} V, gains {:.3f} and {:.3f} in/(V s)\n", times,
               sheet.null_V.value, sheet.dead_band_V.value, sheet.gain_positive_in_per_V_s.value,
               sheet.gain_negative_in_per_V_s.value);
    EXPECT_NEAR(sheet.null_V.value, -options.valve_null_offset_V, 0.01) << times;
    EXPECT_NEAR(sheet.dead_band_V.value, options.valve_dead_band_V, 0.01) << times;
  }
}

/// At 2 in/(V s) the volts that give 0.5 in/s hardly leave the dead band.
TEST(CharacteriseCampaign, SaysWhatToDoWithARodThatIsTooFast) {
  const config::RigConfig rig = rig_without_following();
  const CharacterisedRig played = characterised(rig, with_flow(rig, 14.0));
  ASSERT_TRUE(played.is_in_place);
  EXPECT_FALSE(played.trips_following);
  EXPECT_GT(played.lowest_in, rig.limits.travel_min_in + 0.5);
  EXPECT_LT(played.highest_in, rig.limits.travel_max_in - 0.5);
  try {
    static_cast<void>(ident::valve_sheet(played.record, config::characterisation_plan(rig)));
    FAIL() << "a sheet of what was hardly seen";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("give its dead band in [following]"), std::string::npos) << error.what();
  }
}

TEST(CharacteriseCampaign, HasIntervalsThatCoverTheTruth) {
  const config::RigConfig rig = rig_without_following();
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  ident::PortableDraw draw(17);
  constexpr int kSeeds = 200;
  std::array<int, 4> covered{};
  std::array<double, 4> squares{};
  std::array<double, 4> sums{};
  int hysteresis = 0;
  for (int i = 0; i < kSeeds; ++i) {
    const hal::SimOptions options = perturbed(rig, draw);
    const Truth truth = truth_of(options);
    const ident::ValveSheet sheet = ident::valve_sheet(characterised(rig, options).record, plan);
    const std::array<ident::Measured, 4> found{sheet.null_V, sheet.dead_band_V, sheet.gain_positive_in_per_V_s,
                                               sheet.gain_negative_in_per_V_s};
    const std::array<double, 4> wanted{truth.null_V, truth.dead_band_V, truth.gain_positive, truth.gain_negative};
    for (std::size_t k = 0; k < found.size(); ++k) {
      covered[k] += covers(found[k], wanted[k]) ? 1 : 0;
      const double share = (found[k].value - wanted[k]) / found[k].half_width;
      sums[k] += share / kSeeds;
      squares[k] += share * share / kSeeds;
    }
    hysteresis += sheet.has_hysteresis ? 1 : 0;
  }
  const std::array<const char*, 4> names{"null", "dead band", "gain extending", "gain retracting"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    fmt::print("{}: {} of {} intervals cover; errors over half widths: mean {:+.2f}, rms {:.2f}\n", names[k],
               covered[k], kSeeds, sums[k], std::sqrt(squares[k]));
    EXPECT_GE(covered[k], 0.92 * kSeeds) << names[k];
    EXPECT_LT(std::sqrt(squares[k]), 1.0);
    EXPECT_GT(std::sqrt(squares[k]), 0.1) << names[k] << ": an interval ten times too wide says nothing";
  }
  EXPECT_EQ(hysteresis, 0) << "claimed where there is none";
}

TEST(CharacteriseCampaign, KnowsHowLittleSoftOilTells) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  for (const double bulk_modulus_bar : {1000.0, 1500.0, 3000.0}) {
    int covered = 0;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      auto options = std::get<hal::SimOptions>(rig.backend);
      options.bulk_modulus_bar = bulk_modulus_bar;
      options.seed = seed;
      const ident::ValveSheet sheet = ident::valve_sheet(characterised(rig, options).record, plan);
      covered += covers(sheet.null_V, -options.valve_null_offset_V) ? 1 : 0;
      covered += covers(sheet.dead_band_V, options.valve_dead_band_V) ? 1 : 0;
      EXPECT_LT(sheet.null_V.half_width, 0.025) << bulk_modulus_bar;
    }
    EXPECT_GE(covered, 5) << "of 6 intervals at " << bulk_modulus_bar << " bar";
  }
}

TEST(CharacteriseCampaign, ObservesTheSpoolsOfSlowValves) {
  const config::RigConfig rig = rig_without_following();
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  ident::PortableDraw draw(23);
  for (const double natural_frequency_Hz : {4.0, 6.0, 9.0}) {
    hal::SimOptions options = perturbed(rig, draw);
    options.valve_natural_frequency_Hz = natural_frequency_Hz;
    const ident::ValveSheet sheet = ident::valve_sheet(characterised(rig, options).record, plan);
    ASSERT_TRUE(sheet.natural_frequency_Hz && sheet.damping_ratio) << natural_frequency_Hz;
    EXPECT_NEAR(sheet.natural_frequency_Hz->value, natural_frequency_Hz, 0.06 * natural_frequency_Hz);
    EXPECT_NEAR(sheet.damping_ratio->value, 0.8, 0.08) << natural_frequency_Hz;
    ASSERT_TRUE(sheet.responses[0].minus_90deg_Hz.has_value()) << natural_frequency_Hz;
    EXPECT_NEAR(sheet.responses[0].minus_90deg_Hz->value, natural_frequency_Hz, 0.06 * natural_frequency_Hz);
    EXPECT_FALSE(sheet.has_hysteresis) << natural_frequency_Hz << " Hz: " << sheet.hysteresis_V.value << " V";
  }
}

TEST(CharacteriseCampaign, AgreesWithItselfOnceTheRigFileKnowsTheValve) {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  for (const char* name : {"sim", "sim-sticky", "sim-leaky", "sim-worn"}) {
    rig = config::load_rig(fmt::format("{}/config/rigs/{}.toml", EHA_SOURCE_DIR, name));
    const auto& options = std::get<hal::SimOptions>(rig.backend);
    const CharacterisedRig played = characterised(rig, options);
    ASSERT_TRUE(played.is_in_place) << name;
    EXPECT_FALSE(played.trips_following) << name;
    const ident::ValveSheet sheet = ident::valve_sheet(played.record, config::characterisation_plan(rig));
    fmt::print("{}: null {:+.4f} (+-{:.4f}) for {:.2f}, dead band {:.4f} for {:.2f}, hysteresis {:.4f}\n", name,
               sheet.null_V.value, sheet.null_V.half_width, -options.valve_null_offset_V, sheet.dead_band_V.value,
               options.valve_dead_band_V, sheet.hysteresis_V.value);
    EXPECT_TRUE(covers(sheet.null_V, -options.valve_null_offset_V)) << name;
    EXPECT_TRUE(covers(sheet.dead_band_V, options.valve_dead_band_V)) << name;
    EXPECT_FALSE(sheet.has_hysteresis) << name;
  }
}

}  // namespace
}  // namespace eha::place
