// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/recommendation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {
namespace {

enum class Order { whole, estimated };
enum class Figures { good, bad_validation, unconverged };

Model model_of(const std::string& name, double ar_bic, Order order = Order::whole, Figures figures = Figures::good) {
  Model model;
  model.name = name;
  model.estimation.emplace();
  model.estimation->converged = figures != Figures::unconverged;
  model.estimation->score.r2_percent = 99.0;
  model.estimation->correlation.emplace();
  model.estimation->information.emplace();
  model.estimation->information->ar_bic = ar_bic;
  model.estimation->information->samples = 490;
  model.estimation->information->record = "one record";
  const double std = 0.01;
  model.parameters.push_back(
      {"a2", 1.0, std, 1.0 - 2.0 * std, 1.0 + 2.0 * std, false, ParameterRole::denominator_coefficient});
  if (order == Order::estimated) {
    model.parameters.push_back(
        {"n2", 1.8, std, 1.8 - 2.0 * std, 1.8 + 2.0 * std, false, ParameterRole::denominator_order});
  }
  model.validation.emplace();
  model.validation->score.r2_percent = figures == Figures::bad_validation ? 20.0 : 99.0;
  model.stability = StabilityReport{.stable = true, .test = "matignon", .margin_rad = 0.1};
  model.verdict = judge(model, {});
  return model;
}

Recommendation recommended(const std::vector<Model>& models) {
  std::vector<const Model*> all;
  for (const Model& model : models) all.push_back(&model);
  return recommend(all, {});
}

TEST(Recommendation, TakesTheLeastCriterionAndNamesTheRunnerUp) {
  const Recommendation found = recommended({model_of("io", -100.0), model_of("io3", -107.0), model_of("io1", -90.0)});
  EXPECT_EQ(found.model, "io3");
  EXPECT_EQ(found.runner_up, "io");
  EXPECT_FALSE(found.validation_chose);
  EXPECT_TRUE(found.is_unclear);
  EXPECT_FALSE(recommended({model_of("io", -100.0), model_of("io3", -111.0)}).is_unclear);
  EXPECT_EQ(found.reason,
            "its AR-BIC of -107.0 is the least of 3 models, 7.0 below that of io; a difference below 10 is not clear: "
            "this record hardly tells io3 from io");
  EXPECT_EQ(recommended({model_of("io", -100.0), model_of("io3", -111.0)}).reason,
            "its AR-BIC of -111.0 is the least of 2 models, 11.0 below that of io");
  EXPECT_EQ(sentence(found), "Recommended: io3 (runner-up io): " + found.reason + ".");
}

TEST(Recommendation, TakesNoDriftForThePlantWhereAnotherModelIsAccepted) {
  // The zero and the pole at 0 of the second are both slower than the 490 s of the record.
  Model drifts = model_of("io", -300.0);
  drifts.transfer_function = {{{3.2, 1.0}, {-0.0008, 0.0}}, {{40.0, 2.0}, {1.0, 1.0}}, 0.0};
  drifts.estimation->score.samples = 490;
  drifts.estimation->compared_step_s = 1.0;
  drifts.verdict = judge(drifts, {});
  ASSERT_TRUE(drifts.verdict->accepted);
  EXPECT_EQ(drifts.verdict->grade, Grade::usable);
  EXPECT_TRUE(drifts.verdict->reasons.front().starts_with("A drift is taken for the plant: "))
      << drifts.verdict->reasons.front();
  const Recommendation found = recommended({model_of("io1", -100.0), drifts});
  EXPECT_EQ(found.model, "io1");
  EXPECT_NE(found.reason.find("io, 200.0 better, takes a drift of the output for a part of the plant"),
            std::string::npos)
      << found.reason;
  EXPECT_EQ(recommended({drifts}).model, "io") << "its figures are there, and the reason";
  // A zero of 400 s shows in 490 s, and a cylinder has none.
  drifts.transfer_function.numerator[1].coefficient = -0.008;
  EXPECT_EQ(judge(drifts, {}).grade, judge(model_of("io", -300.0), {}).grade);
  drifts.transfer_function.numerator = {{3.2, 0.0}};
  EXPECT_EQ(judge(drifts, {}).grade, judge(model_of("io", -300.0), {}).grade);
}

TEST(Recommendation, SaysWhyAnAcceptedModelIsNotRecommendedWhereNoneIs) {
  const Recommendation found = recommended(
      {model_of("fo", -109.0, Order::estimated), model_of("io3", -105.0, Order::whole, Figures::unconverged)});
  EXPECT_EQ(found.model, "");
  EXPECT_TRUE(found.accepted_instead.starts_with(
      "fo is usable: its estimated orders gain too little (AR-BIC) on a model of integer order"))
      << found.accepted_instead;
  EXPECT_EQ(recommended({model_of("io", -100.0)}).accepted_instead, "");
}

TEST(Recommendation, TakesEstimatedOrdersOnlyWhereTheyGainTenOnEveryModelOfIntegerOrder) {
  EXPECT_EQ(recommended({model_of("io", -100.0), model_of("fo", -109.9, Order::estimated)}).model, "io");
  EXPECT_EQ(recommended({model_of("io", -100.0), model_of("fo", -110.1, Order::estimated)}).model, "fo");
  // A model of integer order that is rejected itself counts all the same.
  EXPECT_EQ(recommended({model_of("io", -100.0), model_of("fo", -120.0, Order::estimated),
                         model_of("io3", -111.0, Order::whole, Figures::unconverged)})
                .model,
            "io");
  EXPECT_EQ(recommended({model_of("fo", -109.0, Order::estimated)}).model, "fo");
}

TEST(Recommendation, TakesAMapOnlyWhereItGainsTen) {
  const auto with_map = [](double ar_bic) {
    Model model = model_of("io_valve", ar_bic);
    model.input_map = ValveMap{.null = 0.0, .dead_band = 0.004};
    return model;
  };
  const Recommendation found = recommended({model_of("io", -100.0), with_map(-104.2)});
  EXPECT_EQ(found.model, "io");
  EXPECT_NE(found.reason.find("; io_valve, 4.2 better, has a map, which must gain 10"), std::string::npos)
      << found.reason;
  EXPECT_EQ(recommended({model_of("io", -100.0), with_map(-110.1)}).model, "io_valve");
  EXPECT_EQ(recommended({model_of("io", -80.0, Order::whole, Figures::unconverged), with_map(-84.0)}).model,
            "io_valve");
}

TEST(Recommendation, TakesNoOrdersForFractionalThatAreWholeForAnyUse) {
  Model fo = model_of("fo", -500.0, Order::estimated);
  fo.parameters.back().value = 1.9994;
  EXPECT_EQ(recommended({model_of("io", -100.0), fo}).model, "io");
  EXPECT_EQ(recommended({model_of("io", -100.0, Order::whole, Figures::unconverged), fo}).model, "fo");
  fo.parameters.back().value = 1.97;
  EXPECT_EQ(recommended({model_of("io", -100.0), fo}).model, "fo");
}

TEST(Recommendation, TakesNoEstimatedOrdersThatABentPlantExplains) {
  Model fo = model_of("fo", -150.0, Order::estimated);
  fo.validation->tests.emplace();
  fo.validation->tests->nonlinearity.emplace();
  fo.validation->tests->nonlinearity->test = {.statistic = 60.0, .degrees = 20, .p = 1e-5};
  const Recommendation found = recommended({model_of("io", -100.0), fo});
  EXPECT_EQ(found.model, "io");
  EXPECT_NE(
      found.reason.find("must gain 10 and, as the plant is not linear, the 60 that its nonlinear effects explain"),
      std::string::npos)
      << found.reason;
  fo.estimation->information->ar_bic = -170.1;
  EXPECT_EQ(recommended({model_of("io", -100.0), fo}).model, "fo");
  fo.estimation->information->ar_bic = -150.0;
  fo.validation->tests->nonlinearity->test.p = 0.01;
  EXPECT_EQ(recommended({model_of("io", -100.0), fo}).model, "fo") << "a level that noise alone reaches";
}

TEST(Recommendation, TakesNoEstimatedOrdersWhereOthersComeOutWhole) {
  Model whole = model_of("fo", -150.0, Order::estimated);
  whole.parameters.back().value = 1.995;
  const Recommendation found = recommended({model_of("io", -100.0), whole, model_of("lag", -155.0, Order::estimated)});
  EXPECT_EQ(found.model, "io");
  EXPECT_NE(found.reason.find("on fo, whose estimated orders are whole for any use"), std::string::npos)
      << found.reason;
  EXPECT_EQ(recommended({model_of("io", -100.0), whole, model_of("lag", -161.0, Order::estimated)}).model, "lag");
}

TEST(Recommendation, TakesTheNextWhereTheMapOfTheBestTurnsBack) {
  Model valve = model_of("io_valve", -150.0);
  valve.parameters.push_back({"negative_gain_ratio", -1.4, 0.3, -2.0, -0.8, false, ParameterRole::negative_gain_ratio});
  valve.verdict = judge(valve, {});
  const Recommendation found = recommended({model_of("io", -100.0), valve, model_of("io1", -90.0)});
  EXPECT_EQ(found.model, "io");
  EXPECT_NE(found.reason.find("io_valve, 50.0 better, is rejected: The map is no valve's"), std::string::npos)
      << found.reason;
}

TEST(Recommendation, SaysWhatEstimatedOrdersWouldHaveHadToGain) {
  const Recommendation found = recommended({model_of("io", -100.0), model_of("fo", -104.0, Order::estimated)});
  EXPECT_EQ(found.model, "io");
  EXPECT_EQ(found.runner_up, "fo");
  EXPECT_EQ(found.reason.find("above that of fo"), std::string::npos) << "lower is better\n" << found.reason;
  EXPECT_NE(found.reason.find("(lower is better); that of fo is 4.0 lower, but fo is not taken: estimated orders must "
                              "gain 10, as"),
            std::string::npos)
      << found.reason;
}

TEST(Recommendation, HasOneOrderForEveryTable) {
  std::vector<Model> models{model_of("rejected", -500.0, Order::whole, Figures::unconverged), model_of("far", -90.0),
                            model_of("near", -95.0), model_of("picked", -130.0), model_of("outdone", -80.0)};
  models[0].validation->score.mse = 0.1;
  models[1].validation->score.mse = 3.0;
  models[2].validation->score.mse = 2.0;
  models[3].validation->score.mse = 5.0;
  models[4].validation->score.mse = 1.0;
  models[4].verdict->criteria.push_back(
      {.kind = CriterionKind::above_recommended, .value = 50.0, .limit = 10.0, .passed = false});
  const auto names = [&](const Recommendation& recommendation) {
    std::string text;
    for (const Model& model :
         in_table_order(models, recommendation, [](const Model& m) -> const Model& { return m; })) {
      text += model.name + " ";
    }
    return text;
  };
  EXPECT_EQ(names({.model = "picked"}), "picked near far outdone rejected ");
  EXPECT_EQ(names({}), "rejected near far picked outdone ") << "the least AR-BIC, which the reason names";
  EXPECT_EQ(names({.runner_up = "far"}), "far near picked outdone rejected ");
}

TEST(Recommendation, LeavesOutWhatTheEstimationPartAlreadyRejects) {
  const Recommendation found =
      recommended({model_of("io", -100.0), model_of("io3", -120.0, Order::whole, Figures::unconverged)});
  EXPECT_EQ(found.model, "io");
  EXPECT_EQ(found.runner_up, "io3") << "for want of another one";
  EXPECT_NE(found.reason.find("; io3, 20.0 better, is rejected: The search found no best parameters"),
            std::string::npos)
      << found.reason;
}

TEST(Recommendation, LetsTheEstimationPartChooseAndSaysWhereTheValidationPartHadTo) {
  const Recommendation found =
      recommended({model_of("io", -100.0), model_of("io3", -120.0, Order::whole, Figures::bad_validation)});
  EXPECT_EQ(found.model, "io");
  EXPECT_EQ(found.runner_up, "io3");
  EXPECT_TRUE(found.validation_chose);
  EXPECT_TRUE(
      found.reason.starts_with("its AR-BIC of -100.0 is not the least (lower is better): that of io3 is 20.0 lower"))
      << found.reason;
  EXPECT_NE(found.reason.find("only a fresh record can confirm"), std::string::npos) << found.reason;
  // A good validation does not make up for a worse criterion.
  EXPECT_EQ(recommended({model_of("io", -100.0), model_of("io3", -101.0)}).model, "io3");
}

TEST(Recommendation, TakesAModelThatHasFarLessErrorOnTheUnseenPart) {
  Model io3 = model_of("io3", -120.0);
  io3.parameters.push_back({"b1", 1.0, 0.01, 0.98, 1.02, false, ParameterRole::numerator_coefficient});
  Model io = model_of("io", -100.0);
  io3.validation->score.mse = 5.0;
  io.validation->score.mse = 1.0;
  const Recommendation found = recommended({io, io3});
  EXPECT_EQ(found.model, "io");
  EXPECT_TRUE(found.validation_chose);
  EXPECT_NE(found.reason.find("io3, which the estimation part prefers, errs 2.2 times as much on the unseen part"),
            std::string::npos)
      << found.reason;
  io3.validation->score.mse = 3.9;  // not yet twice the error
  EXPECT_EQ(recommended({io, io3}).model, "io3");
  io3.validation->score.mse = 5.0;
  io.parameters.insert(io.parameters.end(), 2, io3.parameters.back());
  EXPECT_EQ(recommended({io, io3}).model, "io3") << "one with more parameters may be luck";
  io3.validation->score.mse = 9.1;
  EXPECT_EQ(recommended({io, io3}).model, "io") << "but not where it errs a third";
}

TEST(Recommendation, NamesTheModelThatLeavesNothingOverThatTheInputMoves) {
  const auto with_p = [](const std::string& name, double ar_bic, double p, double mse = 1.0) {
    Model model = model_of(name, ar_bic);
    model.validation->score.samples = 500;
    model.validation->score.mse = mse;
    model.validation->tests = ResidualTests{1, {20.0, 21, p}, {19.0, 19, 0.5}};
    model.verdict = judge(model, {});
    return model;
  };
  const std::string named = "; of the accepted ones io3 leaves nothing over that the tests show the input to move";
  EXPECT_NE(recommended({with_p("io", -100.0, 1e-9), with_p("io3", -95.0, 0.5)}).reason.find(named), std::string::npos);
  EXPECT_EQ(recommended({with_p("io", -100.0, 0.1), with_p("io3", -95.0, 0.5)}).reason.find(named), std::string::npos);
  EXPECT_EQ(recommended({with_p("io", -100.0, 1e-9), with_p("io3", -95.0, 0.5, 3.0)}).reason.find(named),
            std::string::npos)
      << "one that errs 1.7 times as much is no advice";
}

TEST(Recommendation, TakesAResonanceFarAboveTheBandOnlyWhereItGainsTen) {
  const auto cylinder = [](double ar_bic, double highest_Hz) {
    Model model = model_of("cylinder", ar_bic);
    // 14.6 Hz, D 0.28
    model.transfer_function.denominator = {{1.19e-4, 3}, {6.1e-3, 2}, {1.0, 1}};
    model.verdict->usable_band = FrequencyInterval{0.05, highest_Hz};
    return model;
  };
  const Recommendation found = recommended({model_of("io1", -100.0), cylinder(-102.2, 0.65)});
  EXPECT_EQ(found.model, "io1");
  EXPECT_FALSE(found.validation_chose);
  EXPECT_NE(found.reason.find("cylinder, 2.2 better, has a resonance at 14.6 Hz"), std::string::npos) << found.reason;
  EXPECT_EQ(recommended({model_of("io1", -100.0), cylinder(-111.0, 0.65)}).model, "cylinder");
  EXPECT_EQ(recommended({model_of("io1", -100.0), cylinder(-102.2, 10.0)}).model, "cylinder") << "the record shows it";
  // An integrator alone has no pole beside the one at 0.
  Model integrator = model_of("integrator", -103.0);
  integrator.transfer_function.denominator = {{1.0, 1}, {0.0, 0}};
  integrator.verdict->usable_band = FrequencyInterval{0.05, 0.65};
  EXPECT_EQ(recommended({integrator, cylinder(-102.2, 0.65)}).model, "integrator");
}

TEST(Recommendation, TakesADeadTimeThatMayBeALagOnlyWhereItGainsTen) {
  const auto delayed = [](double ar_bic, double highest_Hz) {
    Model model = model_of("io1", ar_bic);
    model.transfer_function = {{{12.0, 0.0}}, {{1.0, 1.0}, {0.5, 0.0}}, 0.01};
    model.parameters.push_back({"delay_s", 0.01, 0.002, 0.006, 0.014, false, ParameterRole::delay});
    model.verdict->usable_band = FrequencyInterval{0.05, highest_Hz};
    return model;
  };
  EXPECT_EQ(recommended({model_of("io", -100.0), delayed(-100.6, 0.65)}).model, "io");
  EXPECT_EQ(recommended({model_of("io", -100.0), delayed(-110.6, 0.65)}).model, "io1");
  EXPECT_EQ(recommended({model_of("io", -100.0), delayed(-100.6, 20.0)}).model, "io1") << "the record shows it";
}

TEST(Recommendation, IsNoneWithTheReasonWhereNothingIsAccepted) {
  const Recommendation rejected = recommended({model_of("io", -100.0, Order::whole, Figures::bad_validation)});
  EXPECT_EQ(rejected.model, "");
  EXPECT_NE(rejected.reason.find("validation R2 of 20.00 %"), std::string::npos) << rejected.reason;
  EXPECT_EQ(sentence(rejected).rfind("No model is recommended: ", 0), 0U);
  EXPECT_EQ(recommended({}).model, "");
}

TEST(Recommendation, CallsTheOneNearestThatErrsLeastOnUnseenData) {
  std::vector<Model> models{model_of("io", -130.0, Order::whole, Figures::unconverged),
                            model_of("io1", -100.0, Order::whole, Figures::unconverged),
                            model_of("lag", -120.0, Order::whole, Figures::unconverged)};
  models[0].validation->score.fit_percent = 36.7;
  models[1].validation->score.fit_percent = 41.8;
  models[2].validation->score.fit_percent = 12.0;
  const Recommendation found = recommended(models);
  EXPECT_NE(found.reason.find("io1 comes nearest"), std::string::npos) << found.reason;
  EXPECT_EQ(in_table_order(models, found, [](const Model& m) -> const Model& { return m; }).front().name, "io1");
}

TEST(Recommendation, SaysFirstWhatLiesInTheRecord) {
  std::vector<Model> models{model_of("io", -100.0), model_of("io3", -107.0)};
  for (Model& model : models) {
    model.validation->end_stop = EndStop{.level = 5.9, .from_s = 12.1, .percent = 79.0, .clean_to_s = 12.08};
    model.verdict = judge(model, {});
  }
  const Recommendation found = recommended(models);
  EXPECT_TRUE(found.model.empty());
  EXPECT_EQ(
      found.reason,
      "The output stands at an end (a rod on its end stop, or the sensor at its end), at 5.900 in from 12.1 s on, 79 % "
      "of the samples, and no model follows it there; cut with --to 12.08, or record nearer to the middle of the "
      "range");
}

TEST(Recommendation, SaysFirstThatTheSensorFroze) {
  std::vector<Model> models{model_of("io", -100.0, Order::whole, Figures::bad_validation)};
  models[0].provenance[kFrozenOfRecord] = "from 30 to 49.98 s";
  models[0].provenance[kWithoutFrozen] = "--to 29.98";
  models[0].verdict = judge(models[0], {});
  const Recommendation found = recommended(models);
  EXPECT_TRUE(found.model.empty());
  EXPECT_EQ(found.reason.rfind("The sensor froze from 30 to 49.98 s: ", 0), 0U) << found.reason;
  EXPECT_TRUE(found.reason.ends_with("; cut with --to 29.98")) << found.reason;
}

TEST(Recommendation, CallsARejectedModelSuperfluousOnlyWhereItFitsAsWell) {
  Model io = model_of("io", -100.0);
  io.validation->score.mse = 1.0;
  const auto text_with = [&](double error) {
    Model io3 = model_of("io3", -125.0);
    io3.validation->score.mse = error * error;
    io3.parameters.front().lower95 = -1.0;
    io3.verdict = judge(io3, {});
    return recommended({io, io3}).reason;
  };
  EXPECT_NE(text_with(1.4).find("io3, 25.0 better, is not needed: "), std::string::npos) << text_with(1.4);
  EXPECT_NE(text_with(1.6).find("io3, 25.0 better, is rejected: "), std::string::npos) << text_with(1.6);
}

TEST(Recommendation, DoesNotCallAnAcceptedModelRejected) {
  const Recommendation found = recommended(
      {model_of("fo", -105.0, Order::estimated), model_of("io", -100.0, Order::whole, Figures::unconverged)});
  EXPECT_EQ(found.model, "");
  EXPECT_EQ(found.reason.rfind("fo is accepted, but estimated orders must gain 10", 0), 0U) << found.reason;
  EXPECT_NE(found.reason.find("io is rejected: The search found no best parameters"), std::string::npos)
      << found.reason;
}

TEST(Recommendation, ComparesModelsOfTheSameRowsOnly) {
  Model other = model_of("io3", -500.0);
  other.estimation->information->record = "another record";
  EXPECT_EQ(recommended({model_of("io", -100.0), other}).model, "io");
}

TEST(Recommendation, TakesNoModelThatRingsAtHalfTheRateOfTheRows) {
  Model rings = model_of("io3", -300.0);
  rings.estimation->compared_step_s = 0.2;
  const double w = std::numbers::pi / 0.2;
  rings.transfer_function = {{{1.0, 0.0}}, {{1.0 / (w * w), 2.0}, {0.02 / w, 1.0}, {1.0, 0.0}}, 0.0};
  EXPECT_EQ(recommended({rings, model_of("io", -100.0)}).model, "io");
  EXPECT_EQ(recommended({rings}).model, "io3");
  rings.estimation->compared_step_s = 0.02;
  EXPECT_EQ(recommended({rings, model_of("io", -100.0)}).model, "io3") << "a resonance that the rows show";
}

/// A model with an error on unseen data, and an order of the excitation.
Model erring(const std::string& name, double ar_bic, double mse, int parameters, std::size_t excitation_order) {
  Model model = model_of(name, ar_bic);
  while (static_cast<int>(model.parameters.size()) < parameters) model.parameters.push_back(model.parameters.front());
  model.validation->score.mse = mse;
  model.validation->excitation_order = excitation_order;
  model.verdict = judge(model, {});
  return model;
}

TEST(Recommendation, TakesNoModelOfMoreThanTheInputDeterminesBesideOneThatErrsAsLittle) {
  const Model large = erring("io3", -200.0, 1.0, 5, 2);
  EXPECT_EQ(recommended({large, erring("io1", -150.0, 1.2, 2, 2)}).model, "io1");
  EXPECT_EQ(recommended({large, erring("io1", -150.0, 4.0, 2, 2)}).model, "io3") << "it errs twice as much";
  EXPECT_EQ(recommended({large, erring("io", -150.0, 1.0, 3, 2)}).model, "io3") << "which asks too much, too";
}

TEST(Recommendation, TakesNoParametersThatFitTheStepsOfTheSensor) {
  const auto with_step = [](Model model, double step) {
    model.validation->sensor_step = SensorStep{step};
    return model;
  };
  const Model large = erring("io", -200.0, 1.0, 3, 20);
  const Model small = erring("integrator_lag", -180.0, 1.05, 2, 20);
  EXPECT_EQ(recommended({large, small}).model, "io") << "beside noise";
  EXPECT_EQ(recommended({with_step(large, 3.4), small}).model, "integrator_lag");
  EXPECT_EQ(recommended({with_step(large, 2.0), small}).model, "io") << "a step that makes a third of it";
  EXPECT_EQ(recommended({with_step(large, 3.4), erring("io1", -180.0, 1.3, 2, 20)}).model, "io");
}

TEST(Recommendation, TakesADeadTimeWhereAZeroDoesWhatItDoes) {
  Model pade = erring("io3", -200.0, 1.0, 5, 20);
  pade.transfer_function = {{{-0.308, 1.0}, {22.1, 0.0}}, {{0.00024, 3.0}, {0.0246, 2.0}, {1.0, 1.0}, {4.4, 0.0}}, 0.0};
  Model dead = erring("io1", -188.0, 1.02, 3, 20);
  dead.transfer_function = {{{25.0, 0.0}}, {{1.0, 1.0}, {5.0, 0.0}}, 0.04};
  for (Model* model : {&pade, &dead}) {
    model->verdict = judge(*model, {});
    model->verdict->usable_band = FrequencyInterval{0.03, 1.9};
  }
  EXPECT_EQ(recommended({pade, dead}).model, "io1");
  pade.verdict->usable_band->highest_Hz = 19.0;
  EXPECT_EQ(recommended({pade, dead}).model, "io3") << "the band shows the zero";
}

TEST(Recommendation, TakesAMapInALoopWhereItErrsFarLess) {
  const auto in_loop = [](Model model) {
    model.provenance[kLoopOfRecord] = "-0.33";
    return model;
  };
  Model map = in_loop(erring("io1_valve", -300.0, 1.0, 4, 20));
  map.input_map = ValveMap{};
  EXPECT_EQ(recommended({map, in_loop(erring("io1", -200.0, 3.0, 2, 20))}).model, "io1");
  EXPECT_EQ(recommended({map, in_loop(erring("io1", -200.0, 9.0, 2, 20))}).model, "io1_valve");
}

TEST(Recommendation, TakesNoMapOrOrderThatTakesInTheNoiseOfTheInput) {
  Model plain = model_of("io", -100.0);
  plain.validation->input_noise = InputNoise{.rms = 0.1, .in_output = 0.02, .share = 0.9, .attenuation = 0.001};
  plain.verdict = judge(plain, {});
  Model mapped = model_of("io_valve", -300.0);
  mapped.input_map = ValveMap{};
  EXPECT_EQ(recommended({mapped, plain}).model, "io");
  EXPECT_EQ(recommended({model_of("fo", -300.0, Order::estimated), plain}).model, "io");
  plain.validation->input_noise.reset();
  plain.verdict = judge(plain, {});
  EXPECT_EQ(recommended({mapped, plain}).model, "io_valve");
}

}  // namespace
}  // namespace eha::ident
