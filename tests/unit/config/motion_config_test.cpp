// SPDX-License-Identifier: GPL-3.0-or-later
// Where an experiment wants the rod: [start], [hold], [place]; and tones that do not fit the record.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/characterisation.hpp"
#include "config/needs_following.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"

namespace eha::config {
namespace {

const RigConfig& sim() {
  static const RigConfig rig = load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  return rig;
}

std::string experiment(const std::string& more, double frequency_Hz = 0.25) {
  return "schema = 1\nname = \"bench\"\nduration_s = 20.0\n[excitation]\nkind = \"multisine\"\noffset_V = -0.2\n"
         "tones = [{ frequency_Hz = " +
         std::to_string(frequency_Hz) + ", amplitude_V = 1.0 }]\n[record]\ndiscard_s = 4.0\n" + more;
}

/// The message of the refusal, empty when there is none.
std::string refusal(const std::string& text, const RigConfig& rig = sim()) {
  try {
    static_cast<void>(parse_prepared_experiment(text, "e.toml", rig));
    return "";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

TEST(MotionConfig, ReadsStartAndHold) {
  const auto prepared = parse_prepared_experiment(
      experiment("[start]\ndisplacement_in = 2.5\n[hold]\ngain_V_per_in = 3.0\n"), "e", sim());
  const Played* played = prepared.config.played();
  ASSERT_TRUE(played != nullptr && played->start && played->hold);
  EXPECT_EQ(played->start->displacement_in, 2.5);
  EXPECT_EQ(played->hold->gain_V_per_in, 3.0);
  EXPECT_EQ(prepared.predicted_in.size(), prepared.table_V.size());
  const auto plain = parse_prepared_experiment(experiment(""), "e", sim());
  ASSERT_NE(plain.config.played(), nullptr);
  EXPECT_FALSE(plain.config.played()->start || plain.config.played()->hold);
  EXPECT_EQ(plain.predicted_in.size(), 0);
}

TEST(MotionConfig, RefusesPlacesTooNearToALimit) {
  EXPECT_EQ(refusal(experiment("[start]\ndisplacement_in = 5.6\n")), "");
  EXPECT_TRUE(contains(refusal(experiment("[start]\ndisplacement_in = 5.72\n")), "start.displacement_in: expected 0."));
  const std::string in_mm = refusal(experiment("[start]\ndisplacement_mm = 200\n"));
  EXPECT_TRUE(contains(in_mm, "start.displacement_mm: expected ")) << in_mm;
  EXPECT_TRUE(contains(in_mm, "got 200 mm")) << in_mm;
  EXPECT_TRUE(contains(refusal("schema = 1\nname = \"g\"\nduration_s = 60.0\n[place]\ndisplacement_in = 0.16\n"),
                       "e.toml:5:19: place.displacement_in"));
}

TEST(MotionConfig, BringsAMachinesRodBackOnlyWhereItsSensorIsKnownToBeRight) {
  const std::string text =
      "schema = 1\nname = \"g\"\nduration_s = 60.0\n[place]\ndisplacement_in = 3.0\nway_back = true\n";
  RigConfig rig = load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  rig.limits.following = sim().limits.following;
  rig.limits.sensor = SensorBand{.valid_min_V = 0.1, .valid_max_V = 9.9, .open_circuit_V = -10.0};
  EXPECT_EQ(refusal(text, rig), "");
  rig.limits.sensor->open_circuit_V = 5.0;
  EXPECT_TRUE(contains(refusal(text, rig), "an open_circuit_V outside the valid band")) << refusal(text, rig);
  rig.limits.sensor->open_circuit_V.reset();
  EXPECT_TRUE(contains(refusal(text, rig), "[sensor] with open_circuit_V"));
}

TEST(MotionConfig, PlaysNothingButACharacterisationOnAMachineWithoutFollowing) {
  const std::string place = "schema = 1\nname = \"g\"\nduration_s = 60.0\n[place]\ndisplacement_in = 3.0\n";
  RigConfig rig = load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  for (const std::string& text : {place, place + "way_back = true\n", experiment(""),
                                  experiment("[start]\ndisplacement_in = 2.5\n[hold]\ngain_V_per_in = 1.0\n")}) {
    rig.limits.following = sim().limits.following;
    EXPECT_EQ(refusal(text, rig), "");
    rig.limits.following.reset();
    EXPECT_EQ(refusal(text, rig), "e.toml:1:1: " + rig.file_name + ": " + std::string(kNeedsFollowing));
    RigConfig simulated = sim();
    simulated.limits.following.reset();
    if (!contains(text, "[hold]")) {
      EXPECT_EQ(refusal(text, simulated), "");
    }
  }
  EXPECT_EQ(refusal("schema = 1\nname = \"c\"\n[characterise]\n", rig), "");
}

TEST(MotionConfig, LetsASimulatedRodBeginBeyondALimit) {
  // To practise the way back; beyond its stroke it cannot be.
  std::string text = sim().text;
  const std::string start = "initial_displacement_in = 2.95";
  text.replace(text.find(start), start.size(), "initial_displacement_in = 5.85");
  EXPECT_NO_THROW(static_cast<void>(parse_rig(text, "rig.toml")));
  text.replace(text.find("initial_displacement_in = 5.85"), start.size(), "initial_displacement_in = 5.95");
  EXPECT_THROW(static_cast<void>(parse_rig(text, "rig.toml")), ConfigError);
}

TEST(MotionConfig, TakesAPlaceInsteadOfAnExcitation) {
  const std::string place = "schema = 1\nname = \"g\"\nduration_s = 60.0\n[place]\ndisplacement_in = 3.0\n";
  const auto prepared = parse_prepared_experiment(place, "e.toml", sim());
  ASSERT_NE(prepared.config.placing(), nullptr);
  EXPECT_EQ(prepared.config.placing()->place.displacement_in, 3.0);
  EXPECT_EQ(prepared.table_V.size(), 60'000);
  EXPECT_EQ(prepared.table_V.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_FALSE(prepared.config.placing()->brings_back);
  EXPECT_TRUE(parse_prepared_experiment(place + "way_back = true\n", "e.toml", sim()).config.placing()->brings_back);
  EXPECT_TRUE(contains(refusal(place + "[start]\ndisplacement_in = 3.0\n"), "start: expected no such key"));
  EXPECT_TRUE(contains(refusal(experiment("[place]\ndisplacement_in = 3.0\n")), "excitation: expected no such key"));
}

TEST(MotionConfig, TakesCharacteriseInsteadOfAnExcitation) {
  const std::string text = "schema = 1\nname = \"c\"\n[characterise]\n";
  const auto prepared = parse_prepared_experiment(text, "e.toml", sim());
  EXPECT_TRUE(prepared.config.characterises());
  EXPECT_EQ(prepared.config.played(), nullptr);
  EXPECT_EQ(prepared.config.duration_s, 130.0);
  EXPECT_EQ(prepared.table_V.size(), 130'000);
  const auto started = parse_prepared_experiment(text + "[start]\ndisplacement_in = 2.5\n", "e", sim());
  EXPECT_EQ(std::get<SheetRun>(started.config.kind).start.value().displacement_in, 2.5);
  EXPECT_TRUE(contains(refusal("duration_s = 60.0\n" + text), "duration_s: expected no such key"));
  EXPECT_TRUE(contains(refusal(text + "amplitude_V = 1.0\n"), "characterise.amplitude_V"));
  EXPECT_TRUE(contains(refusal(experiment("[characterise]\n")), "excitation: expected no such key"));
  RigConfig slow = sim();
  slow.realtime.sample_period_s = 0.004;
  EXPECT_EQ(refusal(text, slow), "") << "its 32500 samples need not be a multiple of a decimation that nobody chose";
}

TEST(Centring, ActsGentlyInsideAndTurnsEveryCommandNearTheEnds) {
  const Centring centring = centring_of(sim().limits);
  EXPECT_EQ(centring.correction_V(centring.middle_in), 0.0);
  EXPECT_NEAR(centring.correction_V(centring.middle_in - 1.0), 0.5, 0.01);
  EXPECT_NEAR(centring.correction_V(centring.middle_in + 1.0), -0.5, 0.01);
  // A tenth of the travel before the ends it outweighs a triangle of 1.5 V about a null that is 0.5 V off.
  EXPECT_GT(centring.correction_V(sim().limits.travel_min_in + 0.56), 2.0);
  EXPECT_LT(centring.correction_V(sim().limits.travel_max_in - 0.56), -2.0);
  EXPECT_EQ(centring.correction_V(-100.0), 3.0);
}

TEST(Characterisation, GoesBeyondTheDeadBandOfTheRigFile) {
  const ident::SheetPlan known = characterisation_plan(sim());
  RigConfig rig = sim();
  rig.limits.following.reset();
  const ident::SheetPlan unknown = characterisation_plan(rig);
  EXPECT_EQ(known.table_V[0], -0.2);
  EXPECT_EQ(unknown.table_V[0], 0.0);
  EXPECT_LT(known.sines.front().bias_V, unknown.sines.front().bias_V);
  EXPECT_GT(known.sines.front().bias_V - known.sines.front().amplitude_V, 0.15);
}

TEST(MotionConfig, BoundsTheGainOfAHoldByTheRig) {
  const HoldGains gains = hold_gains(sim());
  EXPECT_NEAR(gains.most, 1.0 / 0.148, 1e-9);
  EXPECT_LT(gains.usual, gains.most);
  EXPECT_TRUE(
      contains(refusal(experiment("[hold]\ngain_V_per_in = 50.0\n")), "hold.gain_V_per_in: expected at most 6.76"));
  RigConfig unknown = sim();
  unknown.limits.following.reset();
  EXPECT_TRUE(contains(refusal(experiment("[hold]\n"), unknown), "hold: expected [following]"));
}

TEST(MotionConfig, EstimatesTheValveWithoutTheMarginsOfTheCheck) {
  const ValveEstimate valve = valve_estimate(*sim().limits.following);
  EXPECT_DOUBLE_EQ(valve.velocity_in_per_s(-0.2 + 0.15), 0.0);
  EXPECT_NEAR(valve.velocity_in_per_s(-0.2 + 1.15), 0.148, 1e-12);
  EXPECT_NEAR(valve.velocity_in_per_s(-0.2 - 1.15), -0.130, 1e-12);
}

TEST(ToneGrid, NamesTheNearestFrequenciesThatFit) {
  const auto sentence = [](const std::string& text) {
    return off_grid_tones(parse_experiment(text, "e.toml")).value_or("");
  };
  // Half of 16 s.
  EXPECT_EQ(sentence(experiment("", 0.25)), "");
  const std::string off = sentence(experiment("", 0.33));
  EXPECT_TRUE(contains(off,
                       "0.33 Hz has no whole number of periods in 8 s, half of what is used of the record; multiples "
                       "of 0.125 Hz do: 0.375 Hz is nearest"))
      << off;
  const std::string repeated = sentence("repetitions = 3\n" + experiment("", 0.33));
  EXPECT_TRUE(contains(repeated, "periods in 20 s, a repetition; multiples of 0.05 Hz do: 0.35 Hz is nearest"))
      << repeated;
  ExperimentConfig paper = load_experiment(EHA_SOURCE_DIR "/config/experiments/paper.toml");
  EXPECT_FALSE(off_grid_tones(paper));
  paper.duration_s = 16.0;
  const std::string is_short = off_grid_tones(paper).value_or("");
  EXPECT_TRUE(
      contains(is_short,
               "periods in 3 s, half of what is used of the record; 0.05 Hz alone needs duration_s = 50 or more. "
               "The measured"))
      << is_short;
  paper.duration_s = 50.0;
  // Of 50 s, which are no multiple of the tones' 20 s: the last repetition is measured as one record is.
  paper.repetitions = 3;
  EXPECT_FALSE(off_grid_tones(paper));
  paper.fit.discard_s = 12.0;
  const std::string two = off_grid_tones(paper).value_or("");
  EXPECT_TRUE(contains(two, "0.05, 0.65 Hz have no whole number of periods in 50 s, a repetition; ")) << two;
}

TEST(SlewRefusal, NamesTheFactorThatPasses) {
  const auto text = [](double amplitude_V) {
    return "schema = 1\nname = \"fast\"\nduration_s = 20.0\n[excitation]\nkind = \"sine\"\ntones = [{ frequency_Hz = "
           "2.0, amplitude_V = " +
           std::to_string(amplitude_V) + " }]\n[record]\ndiscard_s = 4.0\n";
  };
  const std::string message = refusal(text(4.0));
  const std::size_t at = message.find("all amplitudes times ");
  ASSERT_NE(at, std::string::npos) << message;
  const double factor = std::stod(message.substr(at + 21));
  EXPECT_EQ(refusal(text(4.0 * factor)), "");
  EXPECT_NE(refusal(text(4.0 * factor * 1.02)), "");
}

}  // namespace
}  // namespace eha::config
