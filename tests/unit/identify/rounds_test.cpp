// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/rounds.hpp"

#include <gtest/gtest.h>

#include <string>

#include "config/experiment_config.hpp"
#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "daemon/identify/designed_experiment.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/improved_experiment.hpp"
#include "daemon/identify/last_round.hpp"
#include "daemon/rehearsal/rehearsal.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "tests/unit/identify/twin_source.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::identify {
namespace {

const std::string kExperiment = R"(schema = 1
name = "short"
duration_s = 12.0
# repetitions = 9
[excitation]
kind = "multisine"
offset_V = 0.0
tones = [{ frequency_Hz = 0.5, amplitude_V = 1.0, phase_rad = 0.0 }]
[acceptance]
min_validation_r2_percent = 90.0
)";

/// The same with an excitation that does not repeat, from which no noise is to be measured.
std::string without_periods() {
  std::string text = kExperiment;
  const std::size_t begin = text.find("kind =");
  return text.replace(begin, text.find("[acceptance]") - begin, "kind = \"step\"\namplitude_V = 1.0\nhold_s = 1.0\n");
}

/// A noisy plant of two poles, far from one pole, driven by a square wave. @param hold  rows on one level
Source source_with(const std::string& experiment, Eigen::Index hold = 15) {
  Source source;
  source.name = "run";
  source.record.step_s = 0.02;
  source.record.input = Eigen::VectorXd(600);
  for (Eigen::Index k = 0; k < 600; ++k) source.record.input[k] = (k / hold) % 2 == 0 ? 1.0 : -0.5;
  source.record.output =
      ident::simulate({{{1.5, 0.0}}, {{0.02, 2.0}, {0.02, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input, 0.02);
  ident::PortableDraw draw(3);
  for (double& y : source.record.output) y += 0.01 * draw.normal();
  if (!experiment.empty()) source.experiment = config::parse_experiment(experiment, "e.toml");
  return source;
}

IdentificationTask task_with_one_pole(const Source& source) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "one_pole";
  structure.structure = ident::structures::io1();
  task.structures = {structure};
  return task;
}

TEST(LongerExperiment, DoublesTheRepetitionsAndKeepsTheRest) {
  const auto next = longer_experiment(source_with(kExperiment));
  ASSERT_TRUE(next);
  EXPECT_NE(next->text.find("duration_s = 12.0\nrepetitions = 2\n# repetitions = 9\n"), std::string::npos)
      << next->text;
  EXPECT_EQ(config::parse_experiment(next->text, "next.toml").repetitions, 2);
  std::string three = kExperiment;
  three.replace(three.find("# repetitions = 9"), 17, "repetitions = 3  # times");
  const auto six = longer_experiment(source_with(three));
  ASSERT_TRUE(six);
  EXPECT_NE(six->text.find("\nrepetitions = 6  # times\n"), std::string::npos) << six->text;
}

TEST(LongerExperiment, TakesALineOfAnyLength) {
  const std::string comment = " # " + std::string(100'000, 'x');
  std::string text = kExperiment;
  text.replace(text.find("duration_s = 12.0"), 17, "duration_s = 12.0" + comment);
  const auto next = longer_experiment(source_with(text));
  ASSERT_TRUE(next);
  EXPECT_NE(next->text.find(comment + "\nrepetitions = 2\n"), std::string::npos);
}

TEST(LongerExperiment, IsNotOfferedAfterATripWhichItWouldRepeat) {
  Source source = source_with(kExperiment);
  const IdentificationTask task = task_with_one_pole(source);
  Identification whole;
  end_with_experiment(source, task, {}, whole);
  EXPECT_TRUE(whole.next_experiment);
  source.outcome = acquisition::Outcome::faulted;
  Identification tripped;
  end_with_experiment(source, task, {}, tripped);
  EXPECT_FALSE(tripped.next_experiment);
}

TEST(LongerExperiment, HasTheLengthThatIsAskedFor) {
  const auto next = longer_experiment(source_with(kExperiment), 41.0);
  ASSERT_TRUE(next);
  const config::ExperimentConfig longer = config::parse_experiment(next->text, "next.toml");
  EXPECT_GE(longer.repetitions * longer.duration_s, 41.0 + longer.fit.discard_s);
  EXPECT_LT((longer.repetitions - 1) * longer.duration_s, 41.0 + longer.fit.discard_s);
  EXPECT_NE(next->reason.find("s or more are asked for"), std::string::npos) << next->reason;
}

TEST(LongerExperiment, HasMoreTonesWhereASingleOneWasTooShort) {
  Source source = source_with(
      "schema = 1\nname = \"short\"\nduration_s = 3.0\n[excitation]\nkind = \"multisine\"\noffset_V = -0.2\n"
      "tones = [{ frequency_Hz = 1.0, amplitude_V = 0.6 }]\n[record]\ndiscard_s = 0.0\ndecimation = 10\n");
  source.rig_text = eha::test::content_of(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const auto next = longer_experiment(source, 22.2);
  ASSERT_TRUE(next);
  const config::RigConfig rig = config::parse_rig(source.rig_text, "rig.toml");
  const auto prepared = config::parse_prepared_experiment(next->text, "next.toml", rig);
  EXPECT_EQ(prepared.config.duration_s, 12.0) << next->text;
  EXPECT_EQ(prepared.config.repetitions, 2);
  EXPECT_EQ(std::get<ident::Multisine>(prepared.config.played()->excitation.kind).tones.size(), 3U);
  EXPECT_EQ(next->reason.rfind("three tones in 24 s; 22.2 s or more are asked for", 0), 0U) << next->reason;
}

TEST(LongerExperiment, IsAMultisineThatTheRehearsalPassesInPlaceOfAStep) {
  const std::string step =
      "schema = 1\nname = \"step\"\nduration_s = 20.0\n[excitation]\nkind = \"step\"\namplitude_V = 0.5\nhold_s = "
      "2.0\n[record]\ndecimation = 10\n";
  Source source = source_with(step);
  source.rig_text = eha::test::content_of(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const auto next = longer_experiment(source);
  ASSERT_TRUE(next);
  EXPECT_NE(next->text.find("kind = \"multisine\""), std::string::npos) << next->text;
  EXPECT_NE(next->text.find("\n[record]\ndecimation = 10\n"), std::string::npos) << next->text;
  EXPECT_EQ(next->reason.rfind("a multisine moves the input all the time", 0), 0U) << next->reason;
  const config::RigConfig rig = config::parse_rig(source.rig_text, "rig.toml");
  const auto prepared = config::parse_prepared_experiment(next->text, "next.toml", rig);
  EXPECT_EQ(prepared.config.repetitions, 2);
  const auto rehearsal = rehearse(prepared, rig, start_of(rig));
  ASSERT_TRUE(rehearsal);
  EXPECT_LT(rehearsal->chance_of_trip, kWarnedChanceOfTrip);
  // A rod of little travel has no room for the tones.
  const std::string travel = "travel_min_in = 0.15";
  source.rig_text.replace(source.rig_text.find(travel), travel.size(), "travel_min_in = 2.90");
  EXPECT_FALSE(longer_experiment(source));
}

TEST(LongerExperiment, HasGreaterTonesWhereTheVoltsHardlyLeaveTheDeadBand) {
  std::string weak =
      "schema = 1\nname = \"weak\"\nduration_s = 20.0\n[excitation]\nkind = \"sine\"\noffset_V = -0.2\n"
      "tones = [{ frequency_Hz = 0.2, amplitude_V = 0.3 }]\n[record]\ndecimation = 10\n";
  Source source = source_with(weak);
  source.rig_text = eha::test::content_of(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  const auto next = longer_experiment(source);
  ASSERT_TRUE(next);
  const std::string reach = "the volts went 0.3 V from the valve's null, of which its dead band takes 0.15 V";
  EXPECT_EQ(within_dead_band(source), reach);
  EXPECT_EQ(task_of(source).within_dead_band, within_dead_band(source));
  EXPECT_EQ(next->what, "an experiment with greater tones") << "as the report has it";
  EXPECT_EQ(next->reason.rfind(reach, 0), 0U) << next->reason;
  const config::RigConfig rig = config::parse_rig(source.rig_text, "rig.toml");
  EXPECT_GT(config::parse_prepared_experiment(next->text, "next.toml", rig).table_V.maxCoeff(), 1.0);
  weak.replace(weak.find("amplitude_V = 0.3"), 17, "amplitude_V = 0.7");
  source.experiment = config::parse_experiment(weak, "e.toml");
  EXPECT_EQ(within_dead_band(source), "");
  const auto same = longer_experiment(source);
  ASSERT_TRUE(same);
  EXPECT_NE(same->text.find("amplitude_V = 0.7"), std::string::npos) << same->text;
}

TEST(CommandLimit, IsNamedWhereItLeavesNoRoomForLargerAmplitudes) {
  Source source = source_with(kExperiment);
  source.record.input = Eigen::VectorXd::Constant(8, 4.85);
  source.record.output = Eigen::VectorXd::Constant(8, 2.95);
  source.record.output_channel.unit = "in";
  EXPECT_EQ(at_command_limit(source), "") << "a rig that is not known";
  source.rig_text = eha::test::content_of(EHA_SOURCE_DIR "/config/rigs/sim.toml");
  EXPECT_EQ(at_command_limit(source), "the volts reach 4.85 V of the rig's 5 V");
  source.record.input = -source.record.input;
  EXPECT_EQ(at_command_limit(source), "the volts reach -4.85 V of the rig's -5 V");
  source.record.input *= 0.5;
  EXPECT_EQ(at_command_limit(source), "");
  source.record.output[7] = 5.748;
  EXPECT_EQ(at_command_limit(source), "the rod comes to 5.748 in, and the rig's limit is 5.75 in")
      << "as where the limit ended the run";
  source.units = "mm";
  source.record.output *= 25.4;
  source.record.output_channel.unit = "mm";
  EXPECT_TRUE(at_command_limit(source).starts_with("the rod comes to 146 mm")) << at_command_limit(source);
}

TEST(LongerExperiment, EndsAtSixteenRepetitionsAndNeedsAnExperiment) {
  std::string many = kExperiment;
  many.replace(many.find("# repetitions = 9"), 17, "repetitions = 9");
  EXPECT_FALSE(longer_experiment(source_with(many)));
  EXPECT_FALSE(longer_experiment(source_with("")));
}

TEST(Rounds, EndWithTheFirstOneWhereAModelIsAccepted) {
  const Source source = source_with(without_periods());
  IdentificationTask task = task_with_one_pole(source);
  task.structures[0].structure = ident::structures::io();
  const Identification found = identify(source, task, {.ladder = Comparisons::Ladder::include}, {});
  ASSERT_EQ(found.rounds.size(), 1U);
  EXPECT_TRUE(found.rounds[0].accepted);
  EXPECT_FALSE(found.next_experiment);
  EXPECT_EQ(found.recommendation.model, "one_pole");
}

TEST(Rounds, OfferALongerExperimentWhereTheRecordIsTooShortToJudgeTheModel) {
  // Two moves of the input in each half.
  const Source source = source_with(kExperiment, 150);
  IdentificationTask task = task_with_one_pole(source);
  task.structures[0].structure = ident::structures::io();
  const Identification found = identify(source, task, {.ladder = Comparisons::Ladder::include}, {});
  EXPECT_EQ(found.recommendation.model, "one_pole");
  ASSERT_TRUE(found.next_experiment);
  EXPECT_EQ(found.next_experiment->reason.rfind("the record is too short to judge one_pole; 2 repetitions", 0), 0U)
      << found.next_experiment->reason;
}

TEST(Rounds, GoFromOtherStartsToTheLadderWhenTheAskedModelFails) {
  const Source source = source_with(without_periods());
  const Identification found =
      identify(source, task_with_one_pole(source), {.ladder = Comparisons::Ladder::include}, {});
  ASSERT_EQ(found.rounds.size(), 3U);
  EXPECT_EQ(found.rounds[1].what, "other starts (seed 2)");
  EXPECT_EQ(found.rounds[1].reason, "no model passes its checks") << "which one comes nearest may change after them";
  EXPECT_EQ(found.rounds[2].what, "the ladder of structures");
  EXPECT_TRUE(found.rounds[2].accepted);
  EXPECT_EQ(found.recommendation.model, "io") << found.recommendation.reason;
  EXPECT_EQ(found.models.front().structure.name, "one_pole") << "stays";
  EXPECT_FALSE(found.next_experiment);
}

TEST(Rounds, EndWithTheNextExperimentWhenNothingIsAccepted) {
  const Source source = source_with(kExperiment);
  IdentificationTask task = task_with_one_pole(source);
  task.acceptance.min_validation_r2_percent = 99.99999;
  const Identification named = identify(source, task, {}, {});
  ASSERT_EQ(named.rounds.size(), 3U) << "models named on the command line are meant";
  EXPECT_EQ(named.rounds[2].what, "a longer experiment");
  EXPECT_EQ(named.rounds[2].kind, Round::Kind::experiment);
  EXPECT_FALSE(named.rounds[2].accepted);
  EXPECT_TRUE(named.next_experiment);
  EXPECT_EQ(named.recommendation.model, "");
}

/// The paper's tones on the shipped rig, and a model behind its valve whose n2 they hardly determine.
struct WeakOnRig {
  Source source = test::source_of(test::seeded(1));
  ident::FitOptions options = source.experiment->fit;
  ident::Model model;
  WeakOnRig() {
    source.experiment->duration_s = 40.0;
    source.rig_text = eha::test::content_of(EHA_SOURCE_DIR "/config/rigs/sim.toml");
    options.intervals = ident::IntervalMethod::straight;
    ident::StructureOptions asked;
    asked.name = "fo_valve";
    asked.structure = ident::structures::behind_valve(ident::structures::fo());
    model = ident::fit(source.record, asked, options).model;
  }
};

TEST(DesignedExperiment, SaysMoreOfTheParameterWithinTheLimitsOfTheRunsRig) {
  const WeakOnRig weak;
  const DesignedExperiment designed = designed_experiment(weak.source, weak.model, "n2", weak.options, {});
  ASSERT_TRUE(designed.next) << designed.refusal;
  const config::RigConfig rig = config::parse_rig(weak.source.rig_text, "rig.toml");
  const auto prepared = config::parse_prepared_experiment(designed.next->text, "next.toml", rig);
  EXPECT_NEAR(prepared.config.duration_s, 40.0, 1e-9);
  ASSERT_EQ(prepared.config.models.size(), 1U);
  EXPECT_EQ(prepared.config.models[0].name, "fo_valve");
  EXPECT_NE(designed.next->reason.find("n2 of fo_valve within the limits of simulated rig"), std::string::npos)
      << designed.next->reason;
}

TEST(DesignedExperiment, IsRefusedWithTheReasonWhereTheLimitsAreUnknownOrLeaveNoRoom) {
  WeakOnRig weak;
  const std::string limits = weak.source.rig_text;
  weak.source.rig_text = "";
  EXPECT_NE(designed_experiment(weak.source, weak.model, "n2", weak.options, {}).refusal.find("which limits"),
            std::string::npos);
  // The rod begins outside.
  weak.source.rig_text = limits;
  const std::string lowest = "travel_min_in = 0.15";
  weak.source.rig_text.replace(weak.source.rig_text.find(lowest), lowest.size(), "travel_min_in = 5.50");
  const DesignedExperiment none = designed_experiment(weak.source, weak.model, "n2", weak.options, {});
  EXPECT_FALSE(none.next);
  EXPECT_NE(none.refusal.find("limits"), std::string::npos) << none.refusal;
}

/// A rejected model with one failed criterion.
ident::Model rejected_for(const std::string& name, const std::string& criterion, double ar_bic) {
  ident::Model model;
  model.name = name;
  ident::ParameterEstimate order;
  order.name = "n2";
  order.std = 0.4;
  model.parameters = {order};
  model.estimation.emplace().information.emplace().ar_bic = ar_bic;
  ident::Verdict& verdict = model.verdict.emplace();
  verdict.criteria = {ident::criterion_named("std_n1"), ident::criterion_named(criterion)};
  verdict.criteria[0].passed = true;
  return model;
}

TEST(WeakParameter, IsThatOfTheBestModelThatFailsByItsParametersAlone) {
  const ident::Model better = rejected_for("fo", "std_n2", -20.0);
  const ident::Model worse = rejected_for("fo_valve", "left_out_n2", -10.0);
  const ident::Model wrong = rejected_for("io", "validation_r2_percent", -30.0);
  const ident::Model unknown = rejected_for("lag", "interval_a1", -40.0);  // without a standard error
  const auto weak = weak_parameter({&worse, &better, &wrong, &unknown});
  ASSERT_TRUE(weak);
  EXPECT_EQ(weak->model, "fo");
  EXPECT_EQ(weak->parameter, "n2");
  EXPECT_FALSE(weak_parameter({&wrong}));
  ident::Model accepted = better;
  accepted.verdict->accepted = true;
  EXPECT_FALSE(weak_parameter({&accepted}));
  ident::Model grey = better;
  grey.grey_box.emplace();
  EXPECT_FALSE(weak_parameter({&grey})) << "no experiment can be designed for it";
}

TEST(Identify, LeavesOutAModelThatTheRecordDoesNotAllowWhileAnotherOneCanBeFitted) {
  Source source = source_with(kExperiment);
  // Never on the other side of the null.
  source.record.input.array() += 3.0;
  source.record.output =
      ident::simulate({{{1.5, 0.0}}, {{0.02, 2.0}, {0.02, 1.0}, {1.0, 0.0}}, 0.0}, source.record.input, 0.02);
  IdentificationTask task = task_with_one_pole(source);
  task.structures[0].structure = ident::structures::io();
  task.structures.push_back(task.structures[0]);
  task.structures[1].name = "mapped";
  task.structures[1].structure = ident::structures::behind_valve(ident::structures::io());
  task.structures[1].parameters = {{"null", true, 0.0, {}, {}}};
  const Identification found = identify(source, task, {}, {});
  ASSERT_EQ(found.models.size(), 1U);
  ASSERT_EQ(found.refused.size(), 1U);
  EXPECT_EQ(found.refused[0].model, "mapped");
}

}  // namespace
}  // namespace eha::identify
