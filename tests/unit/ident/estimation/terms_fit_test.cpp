// SPDX-License-Identifier: GPL-3.0-or-later
// Fits of structures that are given term by term.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/structure/structures.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

/// Eight tones over two and a half decades: eleven parameters need more than the paper's three.
Eigen::VectorXd rich_excitation(double step_s) {
  const std::vector<double> frequencies_Hz = {0.02, 0.06, 0.15, 0.35, 0.8, 1.7, 3.5, 7.0};
  const std::vector<double> phases_rad = {0.3, 1.9, 4.2, 1.0, 2.0, 3.0, 5.0, 0.5};
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(std::lround(50.0 / step_s)));
  for (std::size_t i = 0; i < frequencies_Hz.size(); ++i) {
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      const double t_s = step_s * static_cast<double>(k);
      u[k] += std::cos(2.0 * std::numbers::pi * frequencies_Hz[i] * t_s + phases_rad[i]);
    }
  }
  return u;
}

Record rich_record(const Model& model, double step_s) {
  Record record;
  record.step_s = step_s;
  record.input = rich_excitation(step_s);
  record.output = simulate(model, record.input, step_s);
  return record;
}

/// (0.5 s^0.5 + 1) / (0.3 s^2.3 + s^1.6 + 1.5 s + 0.8 s^0.45 + 0.4)
Model five_over_two() {
  Model model;
  model.transfer_function = {
      {{0.5, 0.5}, {1.0, 0.0}}, {{0.3, 2.3}, {1.0, 1.6}, {1.5, 1.0}, {0.8, 0.45}, {0.4, 0.0}}, 0.0};
  return model;
}

TEST(TermsFit, RecoversFiveTermsUnderTwoWithThreeFreeOrders) {
  const StructureOptions asked = asked_for(structure_of_terms({.numerator = {{.order = 0.5}, {.order = 0.0}},
                                                               .denominator = {{.order = 2.1, .free = true},
                                                                               {.order = 1.5, .free = true},
                                                                               {.order = 1.0},
                                                                               {.order = 0.5, .free = true},
                                                                               {.order = 0.0}}}));
  FitOptions options;
  options.split = 1.0;
  const Model model = fit(rich_record(five_over_two(), 0.02), asked, options).model;
  for (const auto& [name, truth] : std::vector<std::pair<std::string, double>>{{"n4", 2.3},
                                                                               {"n3", 1.6},
                                                                               {"n1", 0.45},
                                                                               {"a4", 0.3 / 0.8},
                                                                               {"a3", 1.0 / 0.8},
                                                                               {"a2", 1.5 / 0.8},
                                                                               {"a0", 0.4 / 0.8},
                                                                               {"b1", 0.5 / 0.8},
                                                                               {"b0", 1.0 / 0.8}}) {
    EXPECT_NEAR(value(model, name), truth, 1e-6) << name;
  }
  EXPECT_EQ(value(model, "n2"), 1.0);
  EXPECT_EQ(value(model, "m1"), 0.5);
  EXPECT_TRUE(model.estimation->converged);
  EXPECT_EQ(model.estimation->information->parameters, 11U);
}

TEST(TermsFit, IsTheFitOfANamedStructureOfTheSameTerms) {
  const Record record = record_of(fractional(0.6, 1.75, 0.9, 0.3, 0.46), 0.02, 0.01, 3);
  const Structure terms = structure_of_terms({.denominator = {{.order = 1.8, .free = true, .lower = 0.05, .upper = 3.0},
                                                              {.order = 0.9, .free = true, .lower = 0.05, .upper = 3.0},
                                                              {.order = 0.0}}});
  const Model named = fit(record, asked_for(structures::fo()), {}).model;
  const Model given = fit(record, asked_for(terms), {}).model;
  for (const char* name : {"n2", "n1", "a2", "a0", "K", "input_bias", "initial_output"}) {
    EXPECT_NEAR(value(given, name), value(named, name), 1e-5 * std::abs(value(named, name)) + 1e-7) << name;
  }
}

TEST(TermsFit, TakesAPolynomialForOneOfIntegerOrder) {
  Model truth;
  truth.transfer_function = {{{2.0, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.5, 0.0}}, 0.0};
  truth.initial_output = 1.5;
  truth.initial_state = {0.7, -0.1};
  const Structure terms = structure_of_terms({.denominator = {{.order = 2.0}, {.order = 1.0}, {.order = 0.0}}});
  const Model model = fit(record_of(truth, 0.02, 0.0, 1), asked_for(terms), {}).model;
  EXPECT_NEAR(value(model, "a2"), 0.2, 2e-5);
  EXPECT_NEAR(value(model, "x0"), 0.7, 1e-4);
}

TEST(TermsFit, HoldsACoefficientAndAMissingConstant) {
  // 2 / (0.3 s^1.8 + s): an integrator behind a fractional lag.
  Model truth;
  truth.transfer_function = {{{2.0, 0.0}}, {{0.3, 1.8}, {1.0, 1.0}}, 0.0};
  const Structure terms =
      structure_of_terms({.denominator = {{.order = 1.7, .free = true}, {.order = 1.0, .coefficient = 1.0 / 0.3}}});
  const Model model = fit(rich_record(truth, 0.01), asked_for(terms), {}).model;
  EXPECT_NEAR(value(model, "n1"), 1.8, 1e-5);
  EXPECT_EQ(value(model, "a0"), 1.0 / 0.3);
  EXPECT_NEAR(value(model, "K"), 2.0 / 0.3, 1e-4);
}

}  // namespace
}  // namespace eha::ident
