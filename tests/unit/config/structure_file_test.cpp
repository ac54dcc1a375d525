// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/structure_file.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/experiment_config.hpp"
#include "core/error.hpp"
#include "edited.hpp"

namespace eha::config {
namespace {

const char* const kFiveTerms = R"(denominator = [
  { order = 2.1, free = true, upper = 2.5 },
  { order = 1.5, free = true },
  { order = 1.0 },
  { order = 0.5, free = true },
  { order = 0.0, coefficient = 0.4 },
]
numerator = [{ order = 0.5 }, { order = 0.0 }]
delay = "free"
[[parameter]]
name = "n4"
start = 2.2
)";

std::string faults_of(const std::string& text) {
  try {
    static_cast<void>(parse_structure(text, "s.toml"));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

TEST(StructureFile, GivesTheTermsAndTheRestOfAModel) {
  const ident::StructureOptions asked = parse_structure(kFiveTerms, "s.toml");
  EXPECT_EQ(asked.name, "terms");
  EXPECT_EQ(asked.structure.family, "terms");
  ASSERT_EQ(asked.structure.denominator.size(), 5U);
  EXPECT_EQ(asked.structure.denominator[4].order.value, 2.1);
  EXPECT_EQ(asked.structure.denominator[4].order.upper, 2.5);
  EXPECT_EQ(asked.structure.denominator[0].coefficient.value, 0.4);
  EXPECT_EQ(asked.structure.denominator[0].coefficient.freedom, ident::Freedom::held);
  EXPECT_EQ(asked.structure.numerator.size(), 2U);
  EXPECT_EQ(asked.structure.delay.freedom, ident::Freedom::free);
  ASSERT_EQ(asked.parameters.size(), 1U);
  EXPECT_EQ(asked.parameters[0].start, 2.2);
}

TEST(StructureFile, MayNameAModelAndAnyStructure) {
  const ident::StructureOptions asked =
      parse_structure("schema = 1\nname = \"third\"\nstructure = \"io\"\npoles = 3\n", "s.toml");
  EXPECT_EQ(asked.name, "third");
  EXPECT_EQ(asked.structure.denominator.size(), 4U);
}

TEST(StructureFile, MayPutTheModelBehindAValve) {
  const std::string lag = "structure = \"lag\"\ninput_map = \"valve\"\n";
  EXPECT_EQ(parse_structure(lag, "s.toml").name, "terms_valve");
  EXPECT_TRUE(parse_structure(lag, "s.toml").structure.input_map.valve);
  EXPECT_EQ(parse_structure("name = \"mine\"\n" + lag, "s.toml").name, "mine");
  EXPECT_FALSE(parse_structure("structure = \"lag\"\ninput_map = \"none\"\n", "s.toml").structure.input_map.valve);
  const std::string start = "[[parameter]]\nname = \"dead_band\"\nstart = 0.1\nlower = 0.0\nupper = 0.5\n";
  EXPECT_EQ(parse_structure(lag + start, "s.toml").parameters.size(), 1U);
  EXPECT_EQ(faults_of("structure = \"lag\"\ninput_map = \"valv\"\n"),
            "s.toml:2:13: input_map: expected \"none\" or \"valve\", got \"valv\"");
  EXPECT_NE(
      faults_of(lag + "[[parameter]]\nname = \"input_bias\"\nfixed = true\nstart = 0\n").find("negative_gain_ratio"),
      std::string::npos);
}

TEST(StructureFile, TellsEveryFaultWithItsPlace) {
  EXPECT_EQ(faults_of(edited(kFiveTerms, "order = 1.0 }", "order = 1.5 }")),
            "s.toml:4:13: denominator[2].order: expected each order once, got 1.5 again");
  EXPECT_EQ(faults_of(edited(kFiveTerms, "upper = 2.5", "upper = 9")),
            "s.toml:2:39: denominator[0].upper: expected at most 3, the next higher order that is not free or the "
            "greatest, got 9");
  EXPECT_EQ(faults_of(edited(kFiveTerms, "free = true, upper", "fre = true, upper")),
            "s.toml:2:18: denominator[0].fre: expected a known key (did you mean \"free\"?), got an unknown one");
  EXPECT_EQ(faults_of(edited(kFiveTerms, "n4", "n3x")).substr(0, 42), "s.toml:11:8: parameter[0]: model terms: pa");
  EXPECT_EQ(faults_of("numerator = [{ order = 0 }]\n"),
            "s.toml:1:1: denominator: expected an array of at least one "
            "table, got no such key");
  EXPECT_EQ(faults_of("structure = \"fo\"\ndenominator = [{ order = 1 }]\n"),
            "s.toml:2:15: denominator: expected no such key (structure is not \"terms\"), got an array");
  EXPECT_EQ(faults_of("denominator = [{ order = 1 }]\npoles = 2\n"),
            "s.toml:2:9: poles: expected no such key (structure is neither \"io\" nor \"commensurate\"), got 2");
  EXPECT_EQ(faults_of("denominator = [{ order = 1.8, free = true }, { order = 0 }]\nnumerator = [{ order = 0 }, "
                      "{ order = 1 }]\ninitial_state = \"estimated\"\n"),
            "s.toml:3:17: initial_state: expected \"auto\" or \"none\" (a past input is estimated for models without "
            "zeros), got \"estimated\"");
}

TEST(ExperimentFile, TakesAStructureOfTerms) {
  const ExperimentConfig experiment = parse_experiment(R"(schema = 1
name = "terms"
duration_s = 1
[excitation]
kind = "sine"
tones = [{ frequency_Hz = 1, amplitude_V = 1 }]
[[model]]
name = "two"
structure = "terms"
denominator = [{ order = 1.2, free = true }, { order = 0 }]
)",
                                                       "e.toml");
  ASSERT_EQ(experiment.models.size(), 1U);
  EXPECT_EQ(experiment.models[0].name, "two");
  EXPECT_EQ(experiment.models[0].structure.denominator[1].order.value, 1.2);
  EXPECT_EQ(experiment.models[0].structure.numerator.size(), 1U);
}

}  // namespace
}  // namespace eha::config
