// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/model_text.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "config/structure_file.hpp"

namespace eha::config {
namespace {

using ident::Degrees;
using ident::StructureOptions;
namespace structures = ident::structures;

/// Reads the table back, as a file of one model.
StructureOptions read_back(std::string table) {
  const auto replace = [&](const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = table.find(from, at)) != std::string::npos; at += to.size()) {
      table.replace(at, from.size(), to);
    }
  };
  replace("[[model]]\n", "");
  replace("[[model.parameter]]", "[[parameter]]");
  return parse_structure(table, "s.toml");
}

TEST(ModelText, IsReadBackAsTheSameStructure) {
  std::vector<StructureOptions> all;
  for (const ident::StructureFamily& family : ident::structure_families()) {
    all.push_back({.name = std::string(family.name), .structure = family.make(Degrees{3, 1})});
  }
  all.push_back(
      {.name = "five",
       .structure = ident::structure_of_terms(
           {.numerator = {{0.5}, {0.0}}, .denominator = {{2.1, true, {}, {}, 2.5}, {1.0}, {0.0, false, 0.4}}}),
       .initial_state = ident::InitialState::none});
  all.push_back({.name = "fo_valve",
                 .structure = structures::behind_valve(structures::fo()),
                 .initial_state = ident::InitialState::estimated,
                 .parameters = {{"b0", false, 0.1, 0.0, 0.5}, {"dead_band", true, 0.02, {}, {}}}});
  all.back().structure.delay.freedom = ident::Freedom::free;
  all.back().structure.delay.value = 0.01;
  for (const StructureOptions& asked : all) {
    const std::string text = model_table(asked);
    const StructureOptions read = read_back(text);
    EXPECT_EQ(read.name, asked.name);
    EXPECT_EQ(read.structure.family, asked.structure.family) << text;
    EXPECT_EQ(read.structure.numerator, asked.structure.numerator) << text;
    EXPECT_EQ(read.structure.denominator, asked.structure.denominator) << text;
    EXPECT_EQ(read.structure.base_order, asked.structure.base_order) << text;
    EXPECT_EQ(read.structure.delay, asked.structure.delay) << text;
    EXPECT_EQ(read.structure.input_map.valve.has_value(), asked.structure.input_map.valve.has_value()) << text;
    EXPECT_EQ(read.initial_state, asked.initial_state) << text;
    ASSERT_EQ(read.parameters.size(), asked.parameters.size());
    for (std::size_t k = 0; k < read.parameters.size(); ++k) {
      EXPECT_EQ(read.parameters[k].name, asked.parameters[k].name);
      EXPECT_EQ(read.parameters[k].fixed, asked.parameters[k].fixed);
      EXPECT_EQ(read.parameters[k].start, asked.parameters[k].start);
      EXPECT_EQ(read.parameters[k].lower, asked.parameters[k].lower);
      EXPECT_EQ(read.parameters[k].upper, asked.parameters[k].upper);
    }
  }
}

TEST(ModelText, GivesTheTermsOfAFormThatNoKeyNames) {
  // A third pole and a zero; an integrator without its lag.
  const StructureOptions zero = read_back(model_table({.name = "io3", .structure = structures::io3(1)}));
  EXPECT_EQ(zero.structure.numerator.size(), 2U);
  EXPECT_EQ(zero.structure.denominator.size(), 4U);
  StructureOptions integrator{.name = "integrator_lag", .structure = structures::integrator_lag()};
  integrator.structure.denominator.pop_back();
  const StructureOptions read = read_back(model_table(integrator));
  ASSERT_EQ(read.structure.denominator.size(), 2U);
  EXPECT_EQ(read.structure.denominator[0].coefficient.value, 0.0);
  EXPECT_EQ(read.structure.denominator[0].coefficient.freedom, ident::Freedom::held);
}

}  // namespace
}  // namespace eha::config
