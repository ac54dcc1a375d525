// SPDX-License-Identifier: GPL-3.0-or-later
// The state before the first row: a past input, rest at a level, an initial state together with a bias.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "core/error.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/model/model_output.hpp"
#include "ident/structure/structures.hpp"
#include "ident/validation/parameter_change.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

TEST(PastInput, ActsAsARecordThatBeganEarlier) {
  Model model = fractional(0.6, 1.75, 0.9, 0.04, 0.46);
  model.transfer_function.delay_s = 0.03;
  const double step_s = 0.02;
  // 300 rows of which the first 100 are the past: two windows of 60 and 40 rows.
  Eigen::VectorXd whole = excitation(step_s).head(300);
  whole.head(60).setConstant(2.0);
  whole.segment(60, 40).setConstant(-1.5);
  const Eigen::VectorXd expected = simulate(model, whole, step_s).tail(200);
  Model cut = model;
  cut.past_input = {{-0.8, 0.0, -1.5}, {-2.0, -0.8, 2.0}};
  const Eigen::VectorXd got = simulate(cut, whole.tail(200), step_s);
  EXPECT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-8 * expected.cwiseAbs().maxCoeff());
  // The same with a step that does not divide the windows.
  const Eigen::VectorXd still = Eigen::VectorXd::Zero(100);
  const Eigen::VectorXd coarse = simulate(cut, still, 0.3);
  const Eigen::VectorXd fine = simulate(cut, Eigen::VectorXd::Zero(1500), 0.02);
  for (Eigen::Index k = 0; k < still.size(); ++k) EXPECT_NEAR(coarse[k], fine[15 * k], 1e-8) << k;
}

/// The paper-like model's record from the middle of a longer one.
Record cut_record(double noise) {
  const Model model = fractional(0.6, 1.75, 0.9, 0.04, 0.46);
  Record record;
  record.step_s = 0.02;
  Eigen::VectorXd whole(5000);
  whole << excitation(0.02).reverse(), excitation(0.02);
  const Eigen::VectorXd response = simulate(model, whole, 0.02);
  record.input = whole.tail(2500);
  record.output = response.tail(2500);
  std::mt19937_64 generator(4);
  for (double& y : record.output) y += noise * normal(generator);
  return record;
}

/// A step from `before` at the first row of a plant that was at rest.
Record step_at_the_first_row(double before, double after, double noise) {
  const Model model = fractional(0.3, 2.0, 1.0, 0.5, 0.46);
  Record record;
  record.step_s = 0.02;
  record.input.setConstant(1500, after);
  record.output = simulate(model, (record.input.array() - before).matrix(), record.step_s).array() + 3.0;
  std::mt19937_64 generator(8);
  for (double& y : record.output) y += noise * normal(generator);
  return record;
}

TEST(InputBefore, MakesAStepAtTheFirstRowARecord) {
  const Record record = step_at_the_first_row(0.5, 2.0, 1e-3);
  FitOptions options;
  options.input_before = 0.5;
  const Model model = fit(record, asked_for(structures::io()), options).model;
  EXPECT_NEAR(value(model, "a2"), 0.3, 0.02);
  EXPECT_NEAR(value(model, "a0"), 0.5, 0.02);
  EXPECT_NEAR(value(model, "K"), 0.46, 0.01);
  EXPECT_DOUBLE_EQ(model.input_bias, -0.5);
  EXPECT_NEAR(model.initial_output, 3.0, 0.01);
}

TEST(InputBefore, IsOfferedByTheRefusalOfAConstantInput) {
  const Record record = step_at_the_first_row(0.0, 2.0, 1e-3);
  const auto refusal = [&](const FitOptions& options, const StructureOptions& asked) -> std::string {
    try {
      (void)fit(record, asked, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  StructureOptions asked = asked_for(structures::io());
  EXPECT_NE(refusal({}, asked).find("--input-before VOLTS (input_before_V"), std::string::npos);
  FitOptions same;
  same.input_before = 2.0;
  EXPECT_NE(refusal(same, asked).find("input_before gives too"), std::string::npos);
  FitOptions paper;
  paper.input_before = 0.0;
  paper.procedure = Procedure::paper;
  EXPECT_NE(refusal(paper, asked).find("paper's procedure"), std::string::npos);
  paper.procedure = Procedure::standard;
  asked.parameters.push_back({"input_bias", true, 0.1, {}, {}});
  EXPECT_NE(refusal(paper, asked).find("input_bias"), std::string::npos);
}

TEST(InitialState, IsEstimatedUnderAConstantInput) {
  // The plant returns to rest: its poles show, its gain does not.
  const Model model = fractional(0.3, 2.0, 1.0, 0.5, 0.46);
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(2000);
  whole.head(500).setConstant(2.0);
  Record record;
  record.step_s = 0.02;
  record.input = whole.tail(1500);
  record.output = simulate(model, whole, record.step_s).tail(1500);
  std::mt19937_64 generator(8);
  for (double& y : record.output) y += 1e-3 * normal(generator);
  StructureOptions asked = asked_for(structures::io());
  asked.initial_state = InitialState::estimated;
  const Model fitted = fit(record, asked, {}).model;
  EXPECT_NEAR(value(fitted, "a2"), 0.3, 0.03);
  EXPECT_NEAR(value(fitted, "a0"), 0.5, 0.03);
}

TEST(InitialState, ReachesTheOptimumOfALightlyDampedFreeResponse) {
  // One of the responses to the constant input, to a step and of the state is the sum of the rest.
  const Model model = fractional(1.866, 2.0, 1.0, 18826.0, 3000.0);
  Eigen::VectorXd whole = Eigen::VectorXd::Zero(1985);
  whole.tail(1785).setConstant(90.0);
  Record record;
  record.step_s = 0.003;
  record.input = whole.tail(1785);
  record.output = simulate(model, whole, record.step_s).tail(1785);
  std::mt19937_64 generator(9);
  for (double& y : record.output) y += normal(generator);
  StructureOptions asked = asked_for(structures::io());
  asked.initial_state = InitialState::estimated;
  FitOptions options;
  options.split = 1.0;
  const Model fitted = fit(record, asked, options).model;
  EXPECT_LT(std::abs(value(fitted, "K")), 1e7);
  EXPECT_NEAR(fitted.estimation->score.mse, 1.0, 0.1);
}

TEST(PastInput, OfAnotherRecordExplainsNothing) {
  Model model = fractional(0.6, 1.75, 0.9, 0.04, 1e-6);
  model.past_input = {{-1.0, 0.0, 1e5}, {-9.0, -1.0, -1e5}};
  Record record = record_of(fractional(0.2, 1.2, 0.7, 0.3, 1.0), 0.04, 0.0, 1);
  const ValidationReport report = validate(model, record, {});
  EXPECT_LT(report.offset_reestimated->r2_percent, 1.0);
  model.past_input.back().from_s = -1e9;
  EXPECT_THROW(static_cast<void>(simulate(model, record.input, record.step_s)), ConfigError);
}

TEST(PastInput, OfUnknownCourseLetsTheOrdersBeFound) {
  const Record record = cut_record(0.005);
  StructureOptions structure_at_rest = asked_for(structures::fo());
  StructureOptions excited = structure_at_rest;
  excited.initial_state = InitialState::estimated;
  const Model wrong = fit(record, structure_at_rest, {}).model;
  const Model found = fit(record, excited, {}).model;
  EXPECT_GE(found.past_input.size(), 2U);
  EXPECT_NEAR(found.past_input.back().from_s, -25.0, 0.03);
  EXPECT_GT(std::abs(value(wrong, "n2") - 1.75), 0.03);
  EXPECT_NEAR(value(found, "n2"), 1.75, 0.01);
  EXPECT_NEAR(value(found, "n1"), 0.9, 0.01);
  EXPECT_GT(found.validation->score.r2_percent, 99.9);
  for (const char* name : {"n2", "n1", "K", "a2"}) {
    const auto at = std::find_if(found.parameters.begin(), found.parameters.end(),
                                 [&](const ParameterEstimate& p) { return p.name == name; });
    const double truth = std::string(name) == "n2"   ? 1.75
                         : std::string(name) == "n1" ? 0.9
                         : std::string(name) == "K"  ? 0.46
                                                     : 0.6;
    EXPECT_LT(std::abs(at->value - truth), 4.0 * at->std) << name << ' ' << at->value << " +- " << at->std;
  }
}

/// A step test from rest at 2 V to 5 V: K/a0 is 4, the output at rest 1.5.
Record step_record(double pole_before) {
  Model truth;
  truth.transfer_function = {{{2.0, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.5, 0.0}}, 0.0};
  truth.initial_output = 1.5;
  truth.input_bias = -2.0;
  truth.initial_state = {pole_before, 0.0};
  Record record = record_of(truth, 0.02, 0.0, 1);
  record.input.setConstant(5.0);
  record.input.head(200).setConstant(2.0);
  record.output = simulate(truth, record.input, 0.02);
  std::mt19937_64 generator(8);
  for (double& y : record.output) y += 0.01 * normal(generator);
  return record;
}

TEST(StepTest, BeginsAtRestAtItsFirstLevel) {
  for (const Structure& kind : {structures::io(), structures::fo()}) {
    const Model model = fit(step_record(0.0), asked_for(kind), {}).model;
    EXPECT_EQ(model.input_bias, -2.0);
    EXPECT_NE(model.provenance.at("input_bias").find("at rest"), std::string::npos);
    EXPECT_NEAR(model.initial_output, 1.5, 0.01);
    EXPECT_NEAR(value(model, "K") / value(model, "a0"), 4.0, 0.02);
    EXPECT_TRUE(model.initial_state.empty());
  }
}

TEST(StepTest, LetsABiasBeFreedAndIsNoneWhereTheOutputIsNotLevelBefore) {
  StructureOptions freed = asked_for(structures::io());
  freed.parameters = {{"input_bias", false, {}, {}, {}}};
  EXPECT_NEAR(fit(step_record(0.0), freed, {}).model.input_bias, -2.0, 0.02);
  const Model moving = fit(step_record(3.0), asked_for(structures::io()), {}).model;
  EXPECT_EQ(moving.provenance.count("input_bias") == 1 ? moving.provenance.at("input_bias").find("at rest")
                                                       : std::string::npos,
            std::string::npos);
}

TEST(StepTest, IsToldByTheEstimatingRowsAlone) {
  Record twice = step_record(0.0);
  const Model once = fit(twice, asked_for(structures::io()), {}).model;
  twice.input.tail(500).setConstant(1.0);
  EXPECT_EQ(fit(twice, asked_for(structures::io()), {}).model.transfer_function.denominator[0].coefficient,
            once.transfer_function.denominator[0].coefficient);
}

TEST(Fit, FreesTheBiasBesideAnInitialStateWhenTheOffsetIsHeld) {
  Model truth;
  truth.transfer_function = {{{2.0, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  truth.input_bias = 0.3;
  truth.initial_state = {0.7, -0.1};
  StructureOptions integrator = asked_for(structures::io());
  integrator.initial_state = InitialState::estimated;
  integrator.parameters = {{"a0", true, 0.0, {}, {}}, {"initial_output", true, 0.0, {}, {}}};
  const Model model = fit(record_of(truth, 0.02, 0.0, 1), integrator, {}).model;
  EXPECT_NEAR(model.input_bias, 0.3, 1e-4);
  EXPECT_NEAR(value(model, "K"), 2.0, 1e-3);
}

/// Random levels, held for half a second each, to a lag of 0.18 s with a dead time of 40 ms, at rest at the first one.
/// @param plant_gain  [output unit per input unit]
Record levels_of_a_positioner(std::uint64_t seed, double plant_gain) {
  std::mt19937_64 generator(seed);
  Model plant = fractional(0.0, 2.0, 1.0, 1.0 / 0.18, plant_gain / 0.18);
  plant.transfer_function.denominator.erase(plant.transfer_function.denominator.begin());
  plant.transfer_function.delay_s = 0.04;
  Record record;
  record.step_s = 0.01;
  record.input.resize(1500);
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    record.input[k] = k % 50 == 0 ? 15.0 + 70.0 * uniform(generator) : record.input[k - 1];
  }
  plant.input_bias = -record.input[0];
  plant.initial_output = plant_gain * record.input[0];
  record.output = simulate(plant, record.input, record.step_s);
  for (double& y : record.output) y += 0.05 * normal(generator);
  return record;
}

TEST(AnotherRecord, BeginsAtItsOwnLevelWithADeadTime) {
  for (const bool behind_valve : {false, true}) {
    StructureOptions asked = asked_for(structures::io({1, 0}));
    asked.structure.delay.freedom = Freedom::free;
    if (behind_valve) asked.structure = structures::behind_valve(std::move(asked.structure));
    FitOptions options;
    options.intervals = IntervalMethod::straight;
    options.split = 1.0;
    const Record first = levels_of_a_positioner(1, 1.5);
    const Record second = levels_of_a_positioner(2, 1.5);
    ASSERT_GT(std::abs(first.input[0] - second.input[0]), 5.0);
    const Model model = fit(first, asked, options).model;
    const ValidationReport there = validate(model, second, options);
    EXPECT_LT(std::sqrt(there.score.mse), 0.06) << behind_valve;
    EXPECT_LT(std::sqrt(there.offset_reestimated->mse), 0.06) << behind_valve;
    const OutputOfModel output = output_of(model, second, options);
    EXPECT_LT((output.measured - output.simulated).cwiseAbs().maxCoeff(), 0.4) << behind_valve;
    const PlantChange change = compare_parameters(model, fit(second, asked, options).model, 0.01);
    EXPECT_FALSE(change.changed) << change.parameters.front().name;
    // A plant that changed is still told.
    const Record other = levels_of_a_positioner(3, 1.45);
    EXPECT_GT(std::sqrt(validate(model, other, options).offset_reestimated->mse), 0.5) << behind_valve;
    EXPECT_TRUE(compare_parameters(model, fit(other, asked, options).model, 0.01).changed) << behind_valve;
  }
}

TEST(AnotherRecord, KeepsTheBiasOfAPlantThatIntegrates) {
  Model model;
  model.transfer_function = {{{0.5, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}}, 0.02};
  model.input_bias = 0.3;
  const Record record = record_of(model, 0.02, 0.001, 1);
  FitOptions options;
  options.intervals = IntervalMethod::straight;
  StructureOptions asked = asked_for(structure_family("integrator_lag").make({}));
  asked.structure.delay.freedom = Freedom::free;
  const Model fitted = fit(record, asked, options).model;
  model.input_bias = 0.4;
  const Record other = record_of(model, 0.02, 0.001, 2);
  const PlantChange change = compare_parameters(fitted, fit(other, asked, options).model, 0.01);
  ASSERT_TRUE(change.changed);
  EXPECT_EQ(change.parameters.front().name, "input_bias");
}

}  // namespace
}  // namespace eha::ident
