// SPDX-License-Identifier: GPL-3.0-or-later
// The promises of `eha tune` on simulated rigs that it knows by one characterisation and one run only.
// EHA_TUNE_RIGS: how many instead of 100. EHA_TUNE_FIRST: number of the first.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <vector>

#include "config/rig_config.hpp"
#include "daemon/replay/replay.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/structure/structures.hpp"
#include "tests/unit/place/characterised_rig.hpp"
#include "tests/unit/tune/random_rig.hpp"

namespace eha::tune {
namespace {

int number_of(const char* variable, int otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::atoi(text) : otherwise;
}

/// A run about mid-travel, 48 s: forth and back beyond the dead band, with tones that show the lag while the rod moves.
ident::Record run_of(const hal::SimOptions& rig, double step_s, const ident::ValveSheet& sheet) {
  constexpr double kWay_s = 4.0;
  constexpr double kWay_in = 1.2;
  const auto rows = static_cast<Eigen::Index>(std::lround(48.0 / step_s));
  Eigen::VectorXd volts(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t_s = step_s * static_cast<double>(k);
    const bool extends = std::fmod(t_s + 0.5 * kWay_s, 2.0 * kWay_s) < kWay_s;
    const double gain = extends ? sheet.gain_positive_in_per_V_s.value : sheet.gain_negative_in_per_V_s.value;
    volts(k) = sheet.null_V.value + (extends ? 1.0 : -1.0) * (sheet.dead_band_V.value + kWay_in / kWay_s / gain);
    for (const auto& [frequency_Hz, amplitude_V, phase] : {std::array{0.65, 0.25, 4.2}, std::array{2.1, 0.25, 0.6},
                                                           std::array{5.3, 0.25, 2.5}, std::array{9.7, 0.25, 5.1}}) {
      volts(k) += amplitude_V * std::cos(2.0 * std::numbers::pi * frequency_Hz * t_s + phase);
    }
  }
  return replay::recorded(rig, volts, step_s, rig.seed + 7);
}

ident::Model model_of(const ident::Record& record) {
  ident::StructureOptions asked;
  asked.structure = ident::structures::behind_valve(ident::structures::integrator_lag());
  asked.name = "integrator_lag_valve";
  ident::FitOptions options;
  options.decimation = static_cast<int>(std::lround(0.012 / record.step_s));
  options.discard_s = 2.0;
  options.intervals = ident::IntervalMethod::straight;
  return ident::fit(record, asked, options).model;
}

TEST(TuneCampaign, KeepsItsPromisesOnRandomRigs) {
  const config::RigConfig shipped = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const int rigs = number_of("EHA_TUNE_RIGS", 100);
  const int first = number_of("EHA_TUNE_FIRST", 0);
  int kept_all = 0;
  int margins_kept = 0;
  int holds = 0;
  std::vector<double> shares;
  for (int i = first; i < first + rigs; ++i) {
    ident::PortableDraw draw(1000 + static_cast<std::uint64_t>(i));
    hal::SimOptions truth = random_rig(draw);
    config::RigConfig rig = shipped;
    rig.realtime.sample_period_s = 0.001 * static_cast<double>(1 + draw.below(4));
    if (rig.realtime.sample_period_s > 0.0025 && rig.realtime.sample_period_s < 0.0035) {
      rig.realtime.sample_period_s = 0.002;  // a decimation of 20 ms
    }
    rig.limits.following.reset();
    rig.limits.closed_loop_max_V = 5.0;  // the whole range
    rig.backend = truth;
    const std::string which = fmt::format("rig {}, tick {:g} s", i, rig.realtime.sample_period_s);

    const place::CharacterisedRig played = place::characterised(rig, truth);
    ASSERT_TRUE(played.is_in_place) << which;
    const ident::ValveSheet sheet = ident::valve_sheet(played.record, config::characterisation_plan(rig));
    const ident::Model model = model_of(run_of(truth, rig.realtime.sample_period_s, sheet));

    TuneChoices choices;
    choices.sheet = sheet;
    TuneInputs inputs = tune_inputs(model, rig, choices);
    // The twin knows what was measured, not the rig.
    hal::SimOptions unknown;
    unknown.sensor_noise_V = inputs.task.twin.sensor_noise_V;
    inputs.task.twin = estimated_twin(inputs.plant, unknown);
    inputs.task.twin.sensor_noise_V = inputs.task.axis.noise / inputs.task.twin.scale_in_per_V;
    inputs.task.spread = spread_about_estimated(inputs.plant.valve);
    const Tuned tuned = tune(inputs.plant, inputs.task);

    truth.initial_displacement_in = 1.0 + 4.0 * draw.uniform();
    truth.seed += 99;
    ident::TrialPlan plan = tuned.plan;
    const ident::TrialFigures did = axis_trial(truth, ident::coefficients(tuned.design.settings), plan);
    std::string broken;
    const auto check = [&](const char* name, const ident::Interval& promised, double value) {
      if (value <= promised.upper) return;
      broken += fmt::format(" {} {:.3g} > {:.3g}", name, value, promised.upper);
    };
    check("following rms", tuned.promise.following_rms_in, did.following_rms_in);
    check("following worst", tuned.promise.following_worst_in, did.following_worst_in);
    check("sine", tuned.promise.sine_rms_in, did.sine_rms_in);
    check("overshoot", tuned.promise.overshoot_in, did.overshoot_in);
    check("rest", tuned.promise.rest_error_in, did.rest_error_in);
    check("standing", tuned.promise.standing_in, did.standing_in);
    const ident::LoopMargins margins = true_margins(truth, tuned.design.settings);
    if (rigs == 1) {
      fmt::print(
          "  truth: null {:.3f} V, dead band {:.3f} V, Coulomb {:.0f} N, static {:.0f} N; sheet: null {:.3f} +- {:.3f} "
          "V, dead band {:.3f} +- {:.3f} V, gains {:.4f} {:.4f}, true {:.4f} {:.4f}\n",
          -truth.valve_null_offset_V, truth.valve_dead_band_V, truth.coulomb_friction_N, truth.static_friction_N,
          sheet.null_V.value, sheet.null_V.half_width, sheet.dead_band_V.value, sheet.dead_band_V.half_width,
          sheet.gain_positive_in_per_V_s.value, sheet.gain_negative_in_per_V_s.value, gains_of(truth).positive,
          gains_of(truth).negative);
      for (const std::string& sentence : tuned.remarks) fmt::print("  {}\n", sentence);
      for (const Candidate& c : tuned.candidates) {
        fmt::print(
            "  {} share {:.2f} kp {:.1f} ki {:.1f} filter {:.4f} s: rms {:.5f} rest {:.5f} standing {:.5f}{}, noise "
            "{:.2f}, peak {:.3f}\n",
            ident::text(c.kind), c.share, c.design.settings.feedback.kp, c.design.settings.feedback.ki,
            c.design.settings.feedback.filter_s, c.following_rms_in, c.rest_error_in, c.standing_in,
            c.hunts ? " hunts" : "", c.design.feedback.noise_share, c.design.margins.peak95);
      }
    }
    const bool are_margins_kept = margins.is_stable && margins.ms <= tuned.promise.ms.upper + 0.005 &&
                                  margins.phase_deg >= tuned.promise.phase_margin_deg.lower - 0.5;
    const bool holds_still =
        did.standing_in <= 3.0 * truth.sensor_noise_V * truth.scale_in_per_V + inputs.task.axis.lsb;

    double best_p = std::numeric_limits<double>::infinity();
    for (double kp = 4.0; kp < 200.0; kp *= 1.4) {
      ident::AxisSettings pure = tuned.design.settings;
      pure.kind = ident::FeedbackKind::p;
      pure.feedback = {.kp = kp};
      pure.inverse.dead_band = 0.0;
      pure.inverse.null = 0.0;
      pure.inverse.gain_positive = pure.inverse.gain_negative = 0.15;
      pure.feed_forward = {.velocity_share = 0.0};
      pure.most_speed = 100.0;
      ident::TrialPlan short_plan = plan;
      short_plan.hold_s = 0.5;
      const ident::TrialFigures trial = axis_trial(truth, ident::coefficients(pure), short_plan);
      if (rigs == 1)
        fmt::print("  P {:.1f}: rms {:.5f}, standing {:.5f}\n", kp, trial.following_rms_in, trial.standing_in);
      best_p = std::min(best_p, trial.following_rms_in);
    }
    shares.push_back(did.following_rms_in / best_p);
    kept_all += broken.empty() ? 1 : 0;
    margins_kept += are_margins_kept ? 1 : 0;
    holds += holds_still ? 1 : 0;
    fmt::print(
        "{}: {} kp {:.1f}, rms {:.5f} (to {:.5f}), of best P {:.2f}, standing {:.5f}, Ms {:.3f} (to {:.3f}), "
        "phase {:.1f} (from {:.1f}){}{}{}\n",
        which, ident::text(tuned.design.settings.kind), tuned.design.settings.feedback.kp, did.following_rms_in,
        tuned.promise.following_rms_in.upper, shares.back(), did.standing_in, margins.ms, tuned.promise.ms.upper,
        margins.phase_deg, tuned.promise.phase_margin_deg.lower, broken.empty() ? "" : " NOT KEPT:", broken,
        are_margins_kept ? "" : " MARGIN");
    std::fflush(stdout);
  }
  std::sort(shares.begin(), shares.end());
  fmt::print(
      "{} rigs: promise kept on {}, margins on {}, no standing oscillation on {}; error over that of the best P: "
      "median {:.2f}, worst {:.2f}\n",
      rigs, kept_all, margins_kept, holds, shares[shares.size() / 2], shares.back());
  EXPECT_GE(kept_all, 0.95 * rigs);
  EXPECT_GE(margins_kept, 0.95 * rigs);
  EXPECT_EQ(holds, rigs);
  EXPECT_LE(shares[shares.size() / 2], 1.0 / 3.0);
  EXPECT_LE(shares.back(), 0.5);
}

}  // namespace
}  // namespace eha::tune
