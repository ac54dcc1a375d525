// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/structure/structure.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {
namespace {

std::vector<std::string> names(const std::vector<const StructureParameter*>& parameters) {
  std::vector<std::string> all;
  for (const StructureParameter* parameter : parameters) all.push_back(parameter->key.name);
  return all;
}

using Names = std::vector<std::string>;

TEST(Structures, ListWhatTheirModelFilesList) {
  EXPECT_EQ(names(listed_parameters(structures::io({2, 1}))),
            (Names{"b0", "b1", "a2", "a1", "a0", "delay_s", "input_bias", "initial_output"}));
  EXPECT_EQ(names(listed_parameters(structures::fo())),
            (Names{"K", "a2", "a1", "a0", "n2", "n1", "n0", "b0", "delay_s", "input_bias", "initial_output"}));
  EXPECT_EQ(names(listed_parameters(structures::commensurate())),
            (Names{"K", "a2", "a1", "a0", "q", "delay_s", "input_bias", "initial_output"}));
  EXPECT_EQ(names(listed_parameters(structures::lag())),
            (Names{"K", "a1", "a0", "n1", "n0", "b0", "delay_s", "input_bias", "initial_output"}));
  EXPECT_EQ(names(listed_parameters(structures::io3(1))),
            (Names{"b0", "b1", "a3", "a2", "a1", "a0", "delay_s", "input_bias", "initial_output"}));
}

TEST(Structures, OfAnIntegratorAndALagDeclareAPoleAt0) {
  const StructureOptions integrator{.structure = structures::integrator_lag()};
  EXPECT_TRUE(declares_integrator(integrator));
  EXPECT_EQ(names(requestable_parameters(integrator.structure)),
            (Names{"a2", "K", "delay_s", "input_bias", "initial_output"}));
  EXPECT_TRUE(has_finite_state(integrator.structure));
  EXPECT_FALSE(declares_integrator({.structure = structures::io()}));
  EXPECT_TRUE(declares_integrator({.structure = structures::io(), .parameters = {{"a0", true, 0.0, {}, {}}}}));
  EXPECT_FALSE(declares_integrator({.structure = structures::io(), .parameters = {{"a0", true, 0.1, {}, {}}}}));
  EXPECT_TRUE(
      declares_integrator({.structure = structure_of_terms({.denominator = {{.order = 1.0}, {.order = 2.0}}})}));
  EXPECT_FALSE(declares_integrator({.structure = structures::fo()}));
  EXPECT_TRUE(declares_integrator({.structure = structures::cylinder()}));
}

TEST(Structures, HaveTheFormulaOfTheirTerms) {
  EXPECT_EQ(structures::cylinder().formula, "K/(a3 s^3+a2 s^2+a1 s)");
  EXPECT_EQ(structures::io1().formula, "K/(a1 s+a0)");
  EXPECT_EQ(structures::io3(1).formula, "(b1 s+b0)/(a3 s^3+a2 s^2+a1 s+a0)");
}

TEST(Structures, LetRequestsNameAllButTheirConstants) {
  EXPECT_EQ(names(requestable_parameters(structures::fo())),
            (Names{"a2", "a0", "n2", "n1", "b0", "K", "delay_s", "input_bias", "initial_output"}));
  EXPECT_EQ(names(requestable_parameters(structures::lag())),
            (Names{"a0", "n1", "K", "delay_s", "input_bias", "initial_output"}));
}

TEST(Structures, HaveTheParametersOfAValveInPlaceOfTheBias) {
  const Structure valve = structures::behind_valve(structures::lag());
  EXPECT_EQ(names(listed_parameters(valve)), (Names{"K", "a1", "a0", "n1", "n0", "b0", "delay_s", "null", "dead_band",
                                                    "negative_gain_ratio", "initial_output"}));
  EXPECT_EQ(names(requestable_parameters(valve)),
            (Names{"a0", "n1", "K", "delay_s", "null", "dead_band", "negative_gain_ratio", "initial_output"}));
  EXPECT_EQ(input_map_kind_of(valve).name, "valve");
  EXPECT_EQ(names(requestable_parameters(input_map_kinds().front().put_before(valve))),
            names(requestable_parameters(structures::lag())));
}

TEST(Structures, HaveAFiniteStateWhenAllPowersOfSAreThere) {
  EXPECT_TRUE(has_finite_state(structures::io({3, 1})));
  EXPECT_EQ(state_count(structures::io({3, 1})), 3U);
  EXPECT_FALSE(has_finite_state(structures::fo()));
  EXPECT_FALSE(has_finite_state(structures::commensurate()));
  EXPECT_TRUE(has_equal_steps(structures::commensurate()));
  EXPECT_TRUE(has_finite_state(structure_of_terms({.denominator = {{.order = 0.0}, {.order = 1.0}, {.order = 2.0}}})));
  EXPECT_FALSE(has_finite_state(structure_of_terms({.denominator = {{.order = 1.0}, {.order = 2.0}}})));
  EXPECT_FALSE(has_finite_state(structure_of_terms({.denominator = {{.order = 0.0}, {.order = 1.0, .free = true}}})));
}

TEST(Structures, ArePublishedByTheirTermsNotTheirNames) {
  EXPECT_EQ(published_structure(structures::io())->family, "io");
  EXPECT_EQ(published_structure(structures::fo())->family, "fo");
  EXPECT_FALSE(published_structure(structures::io({2, 1})));
  EXPECT_FALSE(published_structure(structures::io({3, 0})));
  EXPECT_FALSE(published_structure(structures::lag()));
  EXPECT_FALSE(published_structure(structures::integrator_lag()));
  EXPECT_FALSE(published_structure(structures::commensurate()));
  const TermLists fractional{
      .denominator = {{.order = 1.7, .free = true}, {.order = 0.8, .free = true}, {.order = 0.0}}};
  EXPECT_EQ(published_structure(structure_of_terms(fractional))->family, "fo");
}

TEST(Structures, RefuseDegreesThatMakeNoSense) {
  EXPECT_THROW(static_cast<void>(structures::io({0, 0})), ConfigError);
  EXPECT_THROW(static_cast<void>(structures::io({2, 3})), ConfigError);
  EXPECT_THROW(static_cast<void>(structures::commensurate({11, 0})), ConfigError);
  EXPECT_THROW(static_cast<void>(structure_family("oe")), ConfigError);
}

TEST(StructureFamilies, MakeStructuresOfTheirOwnName) {
  for (const StructureFamily& family : structure_families()) {
    EXPECT_EQ(family.make({}).family, family.name);
    EXPECT_EQ(family.make({}).degrees.has_value(), family.has_degrees) << family.name;
    EXPECT_EQ(&structure_family(family.name), &family);
  }
}

TEST(Requests, FreeAndHoldParameters) {
  StructureOptions asked{.structure = structures::fo(),
                         .parameters = {{"n2", true, 1.5, {}, {}}, {"b0", {}, {}, {}, 0.4}}};
  const Structure& fo = asked.structure;
  EXPECT_FALSE(is_estimated(asked, fo.denominator[2].order));
  EXPECT_EQ(requested(asked, fo.denominator[2].order), 1.5);
  EXPECT_TRUE(is_estimated(asked, fo.denominator[1].order));
  EXPECT_EQ(requested(asked, fo.denominator[1].order), 0.9);
  EXPECT_TRUE(is_estimated(asked, fo.numerator[0].order));
  EXPECT_FALSE(is_estimated(asked, fo.denominator[1].coefficient));
  EXPECT_FALSE(is_estimated(asked, fo.delay));
}

}  // namespace
}  // namespace eha::ident
