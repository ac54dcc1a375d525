// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "config/file_kind.hpp"
#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "config/tone_grid.hpp"
#include "daemon/acquisition/following_monitor.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::config {
namespace {

const std::string kDirectory = EHA_CONFIG_DIR;

RigConfig simulated() { return load_rig(kDirectory + "/rigs/sim.toml"); }
RigConfig card() { return load_rig(kDirectory + "/rigs/pci1716.toml"); }
ExperimentConfig characterise() { return load_experiment(kDirectory + "/experiments/characterise.toml"); }
ExperimentConfig paper() { return load_experiment(kDirectory + "/experiments/paper.toml"); }
ExperimentConfig repeated() { return load_experiment(kDirectory + "/experiments/repeated.toml"); }
std::string wide_file() { return kDirectory + "/experiments/wide.toml"; }

/// The shipped files are the documentation of their keys.
void expect_a_comment_on_every_key(const std::string& text) {
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::string line = text.substr(start, end - start);
    start = end + 1;
    const bool is_tone = line.find("{ frequency_Hz") != std::string::npos || line.starts_with("tones = [");
    const bool is_key = line.find(" = ") != std::string::npos && !line.starts_with("#") && !is_tone;
    if (is_key) {
      EXPECT_NE(line.find(" # "), std::string::npos) << line;
    }
  }
}

TEST(ShippedFiles, ExplainEveryKey) {
  for (const std::string& text : {simulated().text, card().text, paper().text, repeated().text, characterise().text,
                                  load_experiment(wide_file()).text}) {
    expect_a_comment_on_every_key(text);
  }
}

TEST(ShippedFiles, TheWideExperimentComesNearToTheSlewLimitAndItsTonesAreLines) {
  const RigConfig rig = simulated();
  const PreparedExperiment wide = load_prepared_experiment(wide_file(), rig);
  const Eigen::Index rest = wide.table_V.size() - 1;
  const double slew_V_per_s = (wide.table_V.tail(rest) - wide.table_V.head(rest)).cwiseAbs().maxCoeff() / 0.001;
  EXPECT_GT(slew_V_per_s, 0.85 * rig.limits.slew_V_per_s);
  EXPECT_FALSE(off_grid_tones(wide.config));
  EXPECT_NEAR((wide.table_V.array() + 0.2).abs().maxCoeff(), 2.05, 0.01) << "as wide.toml says";
}

TEST(ShippedFiles, RepeatsWholePeriodsOfEveryTone) {
  // README's tip: the measured response has an interval at each tone, which further repetitions narrow.
  const ExperimentConfig experiment = repeated();
  EXPECT_FALSE(off_grid_tones(experiment));
  EXPECT_GE(experiment.repetitions, 3);
  EXPECT_GT(prepare(experiment, simulated()).table_V.size(), 0);
}

TEST(ShippedFiles, WornRigsDifferFromTheSimulatedOneAndTakeItsExperiment) {
  for (const char* name : {"sticky", "leaky", "worn"}) {
    const RigConfig rig = load_rig(kDirectory + "/rigs/sim-" + name + ".toml");
    expect_a_comment_on_every_key(rig.text);
    const auto& sim = std::get<hal::SimOptions>(rig.backend);
    EXPECT_FALSE(sim == hal::SimOptions{}) << name;
    EXPECT_TRUE(hal::check(sim).empty()) << name;
    EXPECT_GT(prepare(paper(), rig).table_V.size(), 0) << name;
    ASSERT_TRUE(rig.limits.following) << name;
    EXPECT_NEAR(rig.limits.following->null_V, -sim.valve_null_offset_V, 1e-12) << name;
    EXPECT_GT(rig.limits.following->dead_band_V, sim.valve_dead_band_V) << name;
  }
}

TEST(ShippedFiles, CharacteriseEveryShippedRig) {
  for (const char* name : {"sim", "sim-sticky", "sim-leaky", "sim-worn", "pci1716"}) {
    const RigConfig rig = load_rig(kDirectory + "/rigs/" + name + ".toml");
    EXPECT_EQ(prepare(characterise(), rig).table_V.size(), 130'000) << name;
  }
}

TEST(ShippedFiles, AreToldApart) {
  EXPECT_EQ(kind_of(characterise().text, "c"), FileKind::experiment);
  EXPECT_EQ(kind_of(simulated().text, "a"), FileKind::rig);
  EXPECT_EQ(kind_of(card().text, "b"), FileKind::rig);
  EXPECT_EQ(kind_of(paper().text, "c"), FileKind::experiment);
}

TEST(ShippedFiles, TheSimulatedRigSaysWhatTheSimulatorHasByDefault) {
  const RigConfig rig = simulated();
  EXPECT_TRUE(std::holds_alternative<hal::SimOptions>(rig.backend));
  EXPECT_EQ(std::get<hal::SimOptions>(rig.backend), hal::SimOptions{});
  EXPECT_EQ(rig.realtime.sample_period_s, 0.001);
  EXPECT_FALSE(rig.realtime.cpu.has_value());
}

TEST(ShippedFiles, TheSimulatedRigIsNotTamed) {
  const auto sim = std::get<hal::SimOptions>(simulated().backend);
  const double area_ratio = sim.bore_mm * sim.bore_mm / (sim.bore_mm * sim.bore_mm - sim.rod_mm * sim.rod_mm);
  EXPECT_GT(area_ratio, 1.25);
  EXPECT_GT(sim.valve_dead_band_V, 0.0);
  EXPECT_GT(sim.valve_null_offset_V, 0.1);
  EXPECT_GT(sim.static_friction_N, sim.coulomb_friction_N);
  EXPECT_GT(sim.coulomb_friction_N, 0.0);
  EXPECT_GT(sim.leakage_cm3_per_s_per_bar, 0.0);
  EXPECT_GT(sim.sensor_noise_V, 0.0);
}

TEST(ShippedFiles, TheCardIsWiredAsThePci1716Is) {
  const RigConfig rig = card();
  ASSERT_TRUE(std::holds_alternative<hal::ComediOptions>(rig.backend));
  const auto& wired = std::get<hal::ComediOptions>(rig.backend);
  EXPECT_EQ(wired.board, "pci1716");
  EXPECT_EQ(wired.feedback.subdevice, 0U);
  EXPECT_EQ(wired.feedback.reference, hal::AnalogReference::diff);
  EXPECT_EQ(wired.feedback.channel % 2, 0U);
  EXPECT_EQ(wired.command.subdevice, 1U);
  EXPECT_EQ(wired.command.range_max_V, 5.0);
  ASSERT_TRUE(wired.emergency_stop && wired.enable && wired.heartbeat);
  EXPECT_EQ(wired.emergency_stop->subdevice, 2U);
  EXPECT_EQ(wired.enable->subdevice, 3U);
  EXPECT_NE(wired.enable->channel, wired.heartbeat->channel);
}

TEST(ShippedFiles, TheCommentedEnableContactIsOneThatLoads) {
  std::string text = card().text;
  const std::size_t first = text.find("# [comedi.enable_contact]");
  ASSERT_NE(first, std::string::npos);
  const std::size_t size = text.find("\n\n", first) - first;
  std::string lines = text.substr(first + 2, size - 2);
  for (std::size_t at = lines.find("\n# "); at != std::string::npos; at = lines.find("\n# ")) lines.erase(at + 1, 2);
  text.replace(first, size, lines);
  const RigConfig rig = parse_rig(text, "pci1716.toml");
  const auto& contact = std::get<hal::ComediOptions>(rig.backend).enable_contact;
  ASSERT_TRUE(contact);
  EXPECT_EQ(contact->subdevice, 2U);
  EXPECT_EQ(contact->channel, 1U);
  EXPECT_EQ(contact->follows_within_s, 0.1);
  EXPECT_FALSE(std::get<hal::ComediOptions>(card().backend).enable_contact);
}

TEST(ShippedFiles, ThePaperExperimentIsTheOneInThePaper) {
  const ExperimentConfig experiment = paper();
  EXPECT_EQ(experiment.duration_s, 50.0);
  const std::vector<ident::Tone>& tones = std::get<ident::Multisine>(experiment.played()->excitation.kind).tones;
  EXPECT_EQ(tones.size(), 3U);
  EXPECT_EQ(experiment.fit.discard_s, 10.0);
  EXPECT_EQ(experiment.fit.decimation, 40);
  EXPECT_EQ(experiment.fit.split, 0.5);
  EXPECT_TRUE(experiment.models.empty()) << "the ladder of structures is climbed";
  for (const ident::Tone& tone : tones) {
    EXPECT_GE(tone.frequency_Hz, 0.01);
    EXPECT_LE(tone.frequency_Hz, 1.0);
    // Each 20 s half holds whole periods.
    EXPECT_NEAR(tone.frequency_Hz * 20.0, std::round(tone.frequency_Hz * 20.0), 1e-9);
  }
}

TEST(ShippedFiles, ThePaperExperimentFitsBothRigs) {
  for (const RigConfig& rig : {simulated(), card()}) {
    const PreparedExperiment prepared = prepare(paper(), rig);
    EXPECT_EQ(prepared.table_V.size(), 50000) << rig.file_name;
    EXPECT_NEAR(prepared.table_V.cwiseAbs().maxCoeff(), 4.85, 0.005) << "as paper.toml says";
  }
}

TEST(ShippedFiles, ThePaperExperimentKeepsTheSimulatedRodOffItsTravelLimitsAndFollowing) {
  const RigConfig rig = simulated();
  const Eigen::VectorXd table = prepare(paper(), rig).table_V;
  const auto samples = static_cast<std::size_t>(table.size());
  const auto plant = hal::open(rig.backend, rig.limits.safe_V);
  ASSERT_EQ(plant->set_enable(true), hal::RigStatus::ok);
  double lowest_in = std::numeric_limits<double>::infinity();
  double highest_in = -lowest_in;
  hal::RigReading reading;
  hal::AppliedCommand applied{.applied_V = rig.limits.safe_V, .code = 0};
  acquisition::FollowingMonitor following(acquisition::following_rule(rig.limits));
  following.begin(0);
  const std::int64_t tick_ns = std::llround(rig.realtime.sample_period_s * 1e9);
  // The paper's three repetitions, one after the other.
  for (int repetition = 0; repetition < 3; ++repetition) {
    for (std::size_t k = 0; k < samples; ++k) {
      const auto tick = static_cast<std::int64_t>(static_cast<std::size_t>(repetition) * samples + k);
      ASSERT_EQ(plant->read(tick * tick_ns, reading), hal::RigStatus::ok);
      ASSERT_EQ(following.check(tick * tick_ns, reading.displacement_in, applied.applied_V).fault,
                acquisition::Fault::none);
      ASSERT_EQ(plant->command(table(static_cast<Eigen::Index>(k)), applied), hal::RigStatus::ok);
      lowest_in = std::min(lowest_in, reading.displacement_in);
      highest_in = std::max(highest_in, reading.displacement_in);
    }
    RecordProperty("lowest_in_after_" + std::to_string(repetition + 1), std::to_string(lowest_in));
    RecordProperty("highest_in_after_" + std::to_string(repetition + 1), std::to_string(highest_in));
  }
  RecordProperty("peak_missing_motion", std::to_string(following.peak_missing()));
  EXPECT_LT(following.peak_missing(), 0.8) << "share of the limit";
  EXPECT_LT(following.peak_excess(), 0.8) << "share of the limit";
  constexpr double kMargin_in = 0.3;
  EXPECT_GT(lowest_in, rig.limits.travel_min_in + kMargin_in);
  EXPECT_LT(highest_in, rig.limits.travel_max_in - kMargin_in);
}

}  // namespace
}  // namespace eha::config
