// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/error.hpp"
#include "edited.hpp"
#include "faults_of.hpp"

namespace eha::config {
namespace {

const char* const kExperiment = R"(schema = 1
name = "bench-3"
duration_s = 20.0
repetitions = 3
[excitation]
kind = "multisine"
offset_V = 0.25
tones = [
  { frequency_Hz = 0.1, amplitude_V = 1.0, phase_rad = 0.5 },
  { frequency_Hz = 0.4, amplitude_V = 2.0 },
]
[record]
discard_s = 5.0
decimation = 40
split = 0.75
[identification]
procedure = "default"
seed = 7
[[model]]
name = "third"
structure = "io"
poles = 3
zeros = 1
delay_s = 0.02
delay = "free"
initial_state = "none"
[[model.parameter]]
name = "a0"
fixed = true
start = 0.5
[[model.parameter]]
name = "b1"
lower = 0.0
upper = 2.0
[[model]]
name = "fo"
structure = "fo"
[acceptance]
min_validation_r2_percent = 95.0
max_abs_error_in = 0.2
require_stable = false
min_stability_margin_rad = 0.1
)";

TEST(ExperimentConfig, TakesTheInputBeforeTheRecordAndTheLimitsOfTheUsableBand) {
  std::string text = edited(kExperiment, "split = 0.75", "split = 0.75\ninput_before_V = -0.25");
  text = edited(text, "min_validation_r2_percent = 95.0",
                "min_validation_r2_percent = 95.0\nusable_gain_error_dB = 2\nusable_phase_error_deg = 15");
  const ExperimentConfig experiment = parse_prepared_experiment(text, "e.toml", rig()).config;
  EXPECT_EQ(experiment.fit.input_before, -0.25);
  EXPECT_EQ(experiment.acceptance.usable_gain_error_dB, 2.0);
  EXPECT_EQ(experiment.acceptance.usable_phase_error_deg, 15.0);
}

TEST(ExperimentConfig, TakesEveryKeyToItsPlace) {
  const ExperimentConfig experiment = parse_prepared_experiment(kExperiment, "e.toml", rig()).config;
  EXPECT_EQ(experiment.name, "bench-3");
  EXPECT_EQ(experiment.duration_s, 20.0);
  EXPECT_EQ(experiment.repetitions, 3);
  EXPECT_EQ(experiment.played()->excitation.offset_V, 0.25);
  const std::vector<ident::Tone>& tones = std::get<ident::Multisine>(experiment.played()->excitation.kind).tones;
  ASSERT_EQ(tones.size(), 2U);
  EXPECT_EQ(tones[0].phase_rad, 0.5);
  EXPECT_EQ(tones[1].frequency_Hz, 0.4);
  EXPECT_EQ(tones[1].amplitude_V, 2.0);
  EXPECT_EQ(tones[1].phase_rad, 0.0);
  EXPECT_EQ(experiment.fit.discard_s, 5.0);
  EXPECT_EQ(experiment.fit.decimation, 40);
  EXPECT_EQ(experiment.fit.split, 0.75);
  EXPECT_EQ(experiment.fit.procedure, ident::Procedure::standard);
  EXPECT_EQ(experiment.fit.seed, 7U);
  ASSERT_EQ(experiment.models.size(), 2U);
  const ident::StructureOptions& model = experiment.models[0];
  EXPECT_EQ(model.name, "third");
  EXPECT_EQ(model.structure.family, "io");
  EXPECT_EQ(model.structure.denominator.size(), 4U);
  EXPECT_EQ(model.structure.numerator.size(), 2U);
  EXPECT_EQ(model.structure.delay.value, 0.02);
  EXPECT_EQ(model.structure.delay.freedom, ident::Freedom::free);
  EXPECT_EQ(model.initial_state, ident::InitialState::none);
  ASSERT_EQ(model.parameters.size(), 2U);
  EXPECT_EQ(model.parameters[0].fixed, true);
  EXPECT_EQ(model.parameters[0].start, 0.5);
  EXPECT_FALSE(model.parameters[0].lower.has_value());
  EXPECT_FALSE(model.parameters[1].fixed.has_value());
  EXPECT_EQ(model.parameters[1].upper, 2.0);
  EXPECT_EQ(experiment.models[1].structure.family, "fo");
  EXPECT_EQ(experiment.models[1].structure.delay.freedom, ident::Freedom::held);
  EXPECT_EQ(experiment.acceptance.min_validation_r2_percent, 95.0);
  EXPECT_EQ(experiment.acceptance.max_abs_error, 0.2);
  EXPECT_FALSE(experiment.acceptance.require_stable);
  EXPECT_EQ(experiment.acceptance.min_stability_margin_rad, 0.1);
  EXPECT_EQ(experiment.text, kExperiment);
}

TEST(ExperimentConfig, HasTheOptionsDefaultsForWhatIsLeftOut) {
  const ExperimentConfig experiment = parse_prepared_experiment(R"(schema = 1
name = "short"
duration_s = 1
[excitation]
kind = "sine"
tones = [{ frequency_Hz = 1, amplitude_V = 1 }]
[[model]]
name = "io"
structure = "io"
)",
                                                                "e.toml", rig())
                                          .config;
  EXPECT_EQ(experiment.repetitions, 1);
  EXPECT_EQ(experiment.fit.decimation, 1);
  EXPECT_EQ(experiment.fit.procedure, ident::Procedure::standard);
  EXPECT_EQ(experiment.models[0].structure.denominator.size(), 3U);
  EXPECT_EQ(experiment.models[0].initial_state, ident::InitialState::automatic);
  EXPECT_TRUE(experiment.acceptance.require_stable);
}

struct Edit {
  std::string passage;
  std::string replacement;
  std::vector<std::string> lines;  ///< expected, without the file name
};

void PrintTo(const Edit& edit, std::ostream* stream) { *stream << edit.passage << " -> " << edit.replacement; }

class FaultyExperiment : public testing::TestWithParam<Edit> {};

TEST_P(FaultyExperiment, IsRefusedWithPlaceKeyAndValue) {
  std::vector<std::string> expected;
  for (const std::string& line : GetParam().lines) expected.push_back("e.toml:" + line);
  EXPECT_EQ(faults_of(edited(kExperiment, GetParam().passage, GetParam().replacement)), expected);
}

INSTANTIATE_TEST_SUITE_P(
    Keys, FaultyExperiment,
    testing::Values(
        Edit{"schema = 1", "schema = 2", {"1:10: schema: expected 1, got 2"}},
        Edit{"schema = 1\n", "", {"1:1: schema: expected 1, got no such key"}},
        Edit{"duration_s = 20.0",
             "duratoin_s = 20.0",
             {"1:1: duration_s: expected a number above 0 and of at most 86400, got no such key",
              "3:1: duratoin_s: expected a known key (did you mean \"duration_s\"?), got an unknown one"}},
        Edit{"[record]",
             "[recrod]",
             {"12:2: recrod: expected a known key (did you mean \"record\"?), got an unknown one"}},
        Edit{"split = 0.75",
             "gargantuan_nonsense = 1",
             {"15:1: record.gargantuan_nonsense: expected a known key (one of discard_s, decimation, split, "
              "input_before_V), got an unknown one"}},
        Edit{"discard_s = 5.0",
             "discard = 5.0",
             {"13:1: record.discard: expected a known key (did you mean \"discard_s\"?), got an unknown one"}},
        Edit{"name = \"bench-3\"",
             "name = \"../up\"",
             {"2:8: name: expected a name of at most 64 letters, digits, '.', '_' and '-' that starts with a letter or "
              "digit, got \"../up\""}},
        Edit{"duration_s = 20.0",
             "duration_s = \"20\"",
             {"3:14: duration_s: expected a number above 0 and of at most 86400, got \"20\""}},
        Edit{"duration_s = 20.0",
             "duration_s = 0",
             {"3:14: duration_s: expected a number above 0 and of at most 86400, got 0"}},
        Edit{"duration_s = 20.0",
             "duration_s = inf",
             {"3:14: duration_s: expected a number above 0 and of at most 86400, got inf"}},
        Edit{"duration_s = 20.0",
             "duration_s = 2026-01-01",
             {"3:14: duration_s: expected a number above 0 and of at most 86400, got a date or time"}},
        Edit{"repetitions = 3", "repetitions = 0", {"4:15: repetitions: expected an integer from 1 to 1000, got 0"}},
        Edit{
            "repetitions = 3", "repetitions = 1.5", {"4:15: repetitions: expected an integer from 1 to 1000, got 1.5"}},
        Edit{"offset_V = 0.25", "offset_V = nan", {"7:12: excitation.offset_V: expected a finite number, got nan"}},
        Edit{"frequency_Hz = 0.4",
             "frequency_Hz = 0",
             {"10:20: excitation.tones[1].frequency_Hz: expected a number above 0, got 0"}},
        Edit{"amplitude_V = 2.0",
             "amplitude_mV = 2.0",
             {"10:3: excitation.tones[1].amplitude_V: expected a number above 0, got no such key",
              "10:25: excitation.tones[1].amplitude_mV: expected a known key (did you mean \"amplitude_V\"?), got an "
              "unknown one"}},
        Edit{"discard_s = 5.0",
             "discard_s = -1",
             {"13:13: record.discard_s: expected a number from 0 to 86400, got -1"}},
        Edit{"discard_s = 5.0",
             "discard_s = 20",
             {"13:13: record.discard_s: expected less than duration_s = 20, got 20"}},
        Edit{"decimation = 40",
             "decimation = 0",
             {"14:14: record.decimation: expected an integer from 1 to 100000, got 0"}},
        Edit{"split = 0.75", "split = 0", {"15:9: record.split: expected a number above 0 and of at most 1, got 0"}},
        Edit{"split = 0.75",
             "split = 1.01",
             {"15:9: record.split: expected a number above 0 and of at most 1, got 1.01"}},
        Edit{"procedure = \"default\"",
             "procedure = \"papers\"",
             {"17:13: identification.procedure: expected \"default\", \"paper\" or \"both\", got \"papers\""}},
        Edit{"seed = 7", "seed = -7", {"18:8: identification.seed: expected an integer of at least 0, got -7"}}));

INSTANTIATE_TEST_SUITE_P(
    Models, FaultyExperiment,
    testing::Values(
        Edit{"structure = \"io\"",
             "structure = \"oe\"",
             {"21:13: model[0].structure: expected \"integrator_lag\", \"cylinder\", \"io1\", \"io\", \"io3\", \"fo\", "
              "\"commensurate\", \"lag\", \"friction\", \"outflow\", \"overflow\" or \"terms\", got \"oe\""}},
        Edit{"name = \"fo\"",
             "name = \"third\"",
             {"36:8: model[1].name: expected a name that no other model has, got \"third\""}},
        Edit{"name = \"fo\"",
             "name = \"f/o\"",
             {"36:8: model[1].name: expected a name of at most 64 letters, digits, '.', '_' and '-' that starts with a "
              "letter or digit, got \"f/o\""}},
        Edit{"poles = 3", "poles = 11", {"22:9: model[0].poles: expected an integer from 1 to 10, got 11"}},
        Edit{"zeros = 1", "zeros = 4", {"23:9: model[0].zeros: expected at most poles = 3, got 4"}},
        Edit{"structure = \"fo\"",
             "structure = \"fo\"\npoles = 2",
             {"38:9: model[1].poles: expected no such key (structure is neither \"io\" nor \"commensurate\"), got 2"}},
        Edit{"structure = \"fo\"",
             "structure = \"friction\"\ninput_map = \"valve\"",
             {"38:13: model[1].input_map: expected none before friction, got \"valve\""}},
        Edit{"delay_s = 0.02",
             "delay_s = -0.02",
             {"24:11: model[0].delay_s: expected a number from 0 to 86400, got -0.02"}},
        Edit{"delay = \"free\"", "delay = 0.1", {"25:9: model[0].delay: expected \"free\", got 0.1"}},
        Edit{"initial_state = \"none\"",
             "initial_state = false",
             {"26:17: model[0].initial_state: expected \"auto\", \"none\" or \"estimated\", got false"}},
        Edit{"fixed = true", "fixed = 1", {"29:9: model[0].parameter[0].fixed: expected true or false, got 1"}},
        Edit{
            "upper = 2.0", "upper = -1.0", {"34:9: model[0].parameter[1].upper: expected more than lower = 0, got -1"}},
        Edit{"upper = 2.0",
             "upper = 2.0\nstart = 3",
             {"35:9: model[0].parameter[1].start: expected a number within lower..upper, got 3"}},
        Edit{"name = \"b1\"",
             "name = \"a0\"",
             {"32:8: model[0].parameter[1].name: expected each parameter once, got \"a0\" again"}},
        Edit{"min_validation_r2_percent = 95.0",
             "min_validation_r2_percent = 100.5",
             {"39:29: acceptance.min_validation_r2_percent: expected a number from 0 to 100, got 100.5"}},
        Edit{"max_abs_error_in = 0.2",
             "max_abs_error_in = 0",
             {"40:20: acceptance.max_abs_error_in: expected a number above 0, got 0"}},
        Edit{"require_stable = false",
             "require_stable = \"no\"",
             {"41:18: acceptance.require_stable: expected true or false, got \"no\""}},
        Edit{"min_stability_margin_rad = 0.1",
             "min_stability_margin_rad = 2",
             {"42:28: acceptance.min_stability_margin_rad: expected a number from 0 to 1.5708, got 2"}}));

INSTANTIATE_TEST_SUITE_P(
    AgainstTheRig, FaultyExperiment,
    testing::Values(
        Edit{"duration_s = 20.0",
             "duration_s = 20.0004",
             {"3:14: duration_s: expected a whole number of ticks of 0.001 s, got 20.0004 s, 20000.4 ticks"}},
        Edit{"duration_s = 20.0",
             "duration_s = 80000",
             {"3:14: duration_s: expected at most 10000000 ticks of 0.001 s, got 80000000"}},
        Edit{"decimation = 40",
             "decimation = 33",
             {"14:14: record.decimation: expected a divisor of the 20000 samples, got 33"}},
        Edit{"frequency_Hz = 0.1",
             "frequency_Hz = 500",
             {"9:20: excitation.tones[0].frequency_Hz: expected less than the Nyquist frequency of the tick, 500 Hz, "
              "got 500"}},
        Edit{"frequency_Hz = 0.1, amplitude_V = 1.0",
             "frequency_Hz = 12.5, amplitude_V = 0.1",
             {"9:20: excitation.tones[0].frequency_Hz: expected less than the Nyquist frequency of the decimated "
              "record, 12.5 Hz, got 12.5"}},
        Edit{"amplitude_V = 2.0",
             "amplitude_V = 4.0",
             {"5:1: excitation: expected voltages within the limits of rig.toml, -5..5 V, got 5.129 V at 9.988 s"}},
        Edit{"frequency_Hz = 0.4",
             "frequency_Hz = 4.0",
             {"5:1: excitation: expected changes within the limit of rig.toml, 20 V/s, got 0.05089 V within 0.001 s at "
              "6.688 s (peak 3.25 V, RMS 1.6 V); all amplitudes times 0.392 pass"}}));

TEST(ExperimentConfig, ReportsEveryFaultAtOnceInTheOrderOfTheFile) {
  std::string text = edited(kExperiment, "schema = 1", "schema = 3");
  text = edited(text, "repetitions = 3", "repetitions = \"three\"");
  text = edited(text, "min_validation_r2_percent = 95.0", "min_validation_r2_percent = -5");
  text = edited(text, "decimation = 40", "decimation = 33");
  text = edited(text, "poles = 3", "pole = 3");
  EXPECT_EQ(faults_of(text),
            (std::vector<std::string>{
                "e.toml:1:10: schema: expected 1, got 3",
                "e.toml:4:15: repetitions: expected an integer from 1 to 1000, got \"three\"",
                "e.toml:14:14: record.decimation: expected a divisor of the 20000 samples, got 33",
                "e.toml:22:1: model[0].pole: expected a known key (did you mean \"poles\"?), got an unknown one",
                "e.toml:39:29: acceptance.min_validation_r2_percent: expected a number from 0 to 100, got -5"}));
}

TEST(ExperimentConfig, RefusesBeforeTheExperimentWhatTheEstimatorWouldRefuseAfterIt) {
  EXPECT_EQ(
      faults_of(edited(kExperiment, "name = \"a0\"", "name = \"a7\"")),
      (std::vector<std::string>{"e.toml:28:8: model[0].parameter[0]: model third: parameter a7: expected one of a3, "
                                "a2, a0, b0, b1, delay_s, input_bias, initial_output, got \"a7\""}));
  EXPECT_EQ(faults_of(edited(kExperiment, "start = 0.5\n", "")).size(), 1U);
  const std::string past = "structure = \"commensurate\"\npoles = 2\nzeros = 1\ninitial_state = \"estimated\"";
  EXPECT_EQ(
      faults_of(edited(kExperiment, "structure = \"fo\"", past)),
      (std::vector<std::string>{"e.toml:40:17: model[1].initial_state: expected \"auto\" or \"none\" (a past input "
                                "is estimated for models without zeros), got \"estimated\""}));
  EXPECT_TRUE(faults_of(edited(kExperiment, "structure = \"fo\"", "structure = \"fo\"\ninitial_state = \"estimated\""))
                  .empty());
}

TEST(ExperimentConfig, LeavesThePapersProcedureItsTwoStructuresAndNothingToAskFor) {
  const std::string paper = edited(kExperiment, "procedure = \"default\"", "procedure = \"paper\"");
  EXPECT_EQ(faults_of(paper), (std::vector<std::string>{"e.toml:19:1: model[0]: expected structure \"fo\", or \"io\" "
                                                        "with 2 poles and no zero, for procedure = \"paper\", got "
                                                        "another one"}));
  const std::string second = edited(edited(paper, "poles = 3", "poles = 2"), "zeros = 1", "zeros = 0");
  EXPECT_EQ(faults_of(edited(second, "name = \"b1\"", "name = \"a2\"")),
            (std::vector<std::string>{"e.toml:19:1: model[0]: expected neither a delay nor parameters for procedure = "
                                      "\"paper\", got some"}));
  const std::string plain =
      second.substr(0, second.find("delay_s")) + second.substr(second.find("[[model]]\nname = \"fo\""));
  EXPECT_EQ(parse_prepared_experiment(plain, "e.toml", rig()).config.fit.procedure, ident::Procedure::paper);
}

TEST(ExperimentConfig, ReportsAConflictWithTheRigOnItsOwnToo) {
  const ExperimentConfig experiment =
      parse_experiment(edited(kExperiment, "decimation = 40", "decimation = 33"), "e.toml");
  try {
    (void)prepare(experiment, rig());
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_STREQ(error.what(), "e.toml:14:14: record.decimation: expected a divisor of the 20000 samples, got 33");
  }
}

TEST(ExperimentConfig, RefusesMoreModelsThanAnybodyFits) {
  const auto with_models = [](int count) {
    std::string text = kExperiment;
    const std::size_t first = text.find("[[model]]");
    std::string tables;
    for (int i = 0; i < count; ++i) tables += fmt::format("[[model]]\nname = \"m{}\"\nstructure = \"io\"\n", i);
    return text.substr(0, first) + tables;
  };
  EXPECT_EQ(parse_prepared_experiment(with_models(64), "e.toml", rig()).config.models.size(), 64U);
  const std::vector<std::string> faults = faults_of(with_models(65));
  ASSERT_EQ(faults.size(), 1U) << faults.front();
  EXPECT_NE(faults.front().find("at most 64 tables, got 65"), std::string::npos) << faults.front();
}

TEST(ExperimentConfig, NamesThePlaceOfASyntaxError) {
  EXPECT_EQ(faults_of("schema = 1\nname = \"x\nduration_s = 1\n").at(0).rfind("e.toml:2:", 0), 0U);
  EXPECT_EQ(faults_of("schema = 1\nschema = 1\n").at(0).rfind("e.toml:2:", 0), 0U);
  EXPECT_EQ(faults_of("schema = \xff\n").size(), 1U);
  EXPECT_EQ(faults_of(std::string(100'000, '[')).size(), 1U);
  EXPECT_EQ(faults_of("a = " + std::string(100'000, '[')).size(), 1U);
}

TEST(ExperimentConfig, NeedsAnExcitationButNoModel) {
  const std::vector<std::string> faults = faults_of("schema = 1\nname = \"x\"\nduration_s = 1\n");
  EXPECT_EQ(faults, (std::vector<std::string>{"e.toml:1:1: excitation: expected a table, got no such key"}));
  EXPECT_EQ(faults_of("schema = 1\nname = \"x\"\nduration_s = 1\nmodel = []\nexcitation = 3\n"),
            (std::vector<std::string>{"e.toml:4:9: model: expected an array of at least one table, got an array",
                                      "e.toml:5:14: excitation: expected a table, got 3"}));
}

/// The cost of a fault grows with those before it, and whoever may queue experiments may send such a file.
TEST(ExperimentFile, ListsTheFirstHundredOfThousandsOfFaults) {
  std::string tones;
  for (int k = 0; k < 20'000; ++k) tones += "{a=1},";
  const std::vector<std::string> faults = faults_of(
      "schema = 1\nname = \"t\"\nduration_s = 1.0\n[excitation]\nkind = \"multisine\"\ntones = [" + tones + "]\n");
  EXPECT_EQ(faults.size(), 101U);
  EXPECT_EQ(faults.back(), "e.toml: the first 100 faults that were found; there may be more");
}

}  // namespace
}  // namespace eha::config
