// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {
namespace {

const TermLists kFiveTerms{.numerator = {{.order = 0.5}, {.order = 0.0}},
                           .denominator = {{.order = 2.1, .free = true},
                                           {.order = 1.0},
                                           {.order = 0.5, .free = true, .lower = 0.3},
                                           {.order = 0.0},
                                           {.order = 1.5, .free = true}}};

std::string fault(const TermLists& lists) {
  const auto faults = faults_in_terms(lists);
  if (faults.size() != 1) return std::to_string(faults.size()) + " faults";
  return faults[0].place + ": expected " + faults[0].expected + ", got " + faults[0].got;
}

TEST(Terms, StandByRisingOrderUnderTheNamesOfModelFiles) {
  const Structure structure = structure_of_terms(kFiveTerms);
  EXPECT_EQ(structure.family, "terms");
  ASSERT_EQ(structure.denominator.size(), 5U);
  const std::vector<double> orders = {0.0, 0.5, 1.0, 1.5, 2.1};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(structure.denominator[i].order.value, orders[i]);
    EXPECT_EQ(structure.denominator[i].order.key.name, "n" + std::to_string(i));
    EXPECT_EQ(structure.denominator[i].coefficient.key.name, "a" + std::to_string(i));
    EXPECT_EQ(structure.denominator[i].coefficient.freedom, i == 1 ? Freedom::constant : Freedom::free);
  }
  ASSERT_EQ(structure.numerator.size(), 2U);
  EXPECT_EQ(structure.numerator[1].order.value, 0.5);
  EXPECT_EQ(structure.numerator[1].order.key.name, "m1");
  EXPECT_EQ(structure.numerator[1].coefficient.key.name, "b1");
}

TEST(Terms, KeepFreeOrdersBetweenThoseThatAreNot) {
  const Structure structure = structure_of_terms(kFiveTerms);
  EXPECT_EQ(structure.denominator[1].order.lower, 0.3);
  EXPECT_EQ(structure.denominator[1].order.upper, 1.0);
  EXPECT_EQ(structure.denominator[3].order.lower, 1.0);
  EXPECT_EQ(structure.denominator[3].order.upper, 3.0);
  EXPECT_EQ(structure.denominator[2].order.freedom, Freedom::constant);
  EXPECT_EQ(structure.denominator[4].order.freedom, Freedom::free);
}

TEST(Terms, HoldTheCoefficientsThatAreGiven) {
  const Structure structure = structure_of_terms(
      {.numerator = {{.coefficient = 2.5}}, .denominator = {{.order = 1.0, .coefficient = 1.0}, {.order = 0.0}}});
  EXPECT_EQ(structure.numerator[0].coefficient.key.name, "K");
  EXPECT_EQ(structure.numerator[0].coefficient.freedom, Freedom::held);
  EXPECT_EQ(structure.numerator[0].coefficient.value, 2.5);
  EXPECT_EQ(structure.denominator[0].coefficient.freedom, Freedom::free);
}

TEST(Terms, RefuseWhatMakesNoSense) {
  EXPECT_EQ(fault({.denominator = {}}), "denominator: expected 1 to 11 terms, got 0");
  EXPECT_EQ(fault({.numerator = {}, .denominator = {{.order = 1.0}}}), "numerator: expected 1 to 11 terms, got 0");
  EXPECT_EQ(fault({.denominator = {{.order = -0.5}, {.order = 1.0}}}),
            "denominator[0].order: expected a number from 0 to 20, got -0.5");
  EXPECT_EQ(fault({.denominator = {{.order = 1.0}, {.order = 0.0}, {.order = 1.0}}}),
            "denominator[2].order: expected each order once, got 1 again");
  EXPECT_EQ(fault({.denominator = {{.order = 1.0, .lower = 0.5}, {.order = 0.0}}}),
            "denominator[0].lower: expected no bound of an order that is not free, got 0.5");
  EXPECT_EQ(
      fault({.denominator = {{.order = 1.5, .free = true, .lower = 0.5}, {.order = 1.0}, {.order = 0.0}}}),
      "denominator[0].lower: expected at least 1, the next lower order that is not free or the least order, got 0.5");
  EXPECT_EQ(fault({.denominator = {{.order = 1.5, .free = true, .upper = 1.2}, {.order = 0.0}}}),
            "denominator[0].order: expected a number from 0.05 to 1.2, where this free order may be, got 1.5");
  EXPECT_EQ(
      fault({.denominator = {{.order = 1.0, .coefficient = 2.0}, {.order = 0.0}}}),
      "denominator[0].coefficient: expected 1 (the second lowest order of the denominator has coefficient 1), got 2");
  EXPECT_EQ(fault({.numerator = {{.order = 2.0}}, .denominator = {{.order = 1.0}, {.order = 0.0}}}),
            "numerator[0].order: expected at most 1, the highest order of the denominator, got 2");
  EXPECT_THROW(static_cast<void>(structure_of_terms({.denominator = {}})), ConfigError);
}

}  // namespace
}  // namespace eha::ident
