// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/grey_box_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/export/exported_model.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/record_start.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

Model truth(const GreyBoxKind& kind, std::vector<double> values, double bias) {
  Model model;
  model.name = kind.name;
  model.grey_box = GreyBox{&kind, std::move(values)};
  model.transfer_function = linear_form(*model.grey_box, 0.0);
  model.input_bias = bias;
  model.initial_output = 1.0;
  return model;
}

/// Levels of random height between the limits, each held for some rows.
Record record_of(const Model& model, double step_s, double lowest, double greatest, double noise, std::uint64_t seed,
                 Eigen::Index rows = 1200) {
  PortableDraw draw(seed);
  Record record;
  record.step_s = step_s;
  record.input.resize(rows);
  double level = 0.0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (k % 25 == 0) level = lowest + (greatest - lowest) * draw.uniform();
    record.input[k] = level;
  }
  record.output = simulate(model, record.input, step_s);
  for (double& y : record.output) y += noise * std::sqrt(12.0) * (draw.uniform() - 0.5);
  return record;
}

FitResult fitted(const Record& record, const std::string& family, std::vector<ParameterRequest> requests = {}) {
  StructureOptions asked{.name = family, .structure = structure_family(family).make({})};
  asked.parameters = std::move(requests);
  return fit(record, asked, {});
}

const ParameterEstimate& named(const Model& model, const std::string& name) {
  return *std::find_if(model.parameters.begin(), model.parameters.end(), [&](const auto& p) { return p.name == name; });
}

void expect_found(const Model& model, const std::string& name, double value, double share) {
  const ParameterEstimate& p = named(model, name);
  EXPECT_NEAR(p.value, value, share * std::abs(value)) << name;
  EXPECT_NEAR(p.value, value, 5.0 * p.std) << name;
  EXPECT_FALSE(p.fixed) << name;
}

TEST(GreyBoxFit, FindsAMassWithFriction) {
  const Model plant = truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1);
  const FitResult result = fitted(record_of(plant, 0.02, -3.0, 3.0, 0.002, 1), "friction");
  expect_found(result.model, "gain", 0.2, 0.02);
  expect_found(result.model, "lag_s", 0.4, 0.02);
  expect_found(result.model, "friction", 0.5, 0.02);
  expect_found(result.model, "input_bias", 0.1, 0.05);
  EXPECT_TRUE(result.model.stability->stable);
  EXPECT_GT(result.model.stability->integrator_order, 0.5);
  EXPECT_LT(std::sqrt(result.model.validation->score.mse), 0.0025);
  const Verdict verdict = judge(result.model, {});
  EXPECT_TRUE(verdict.accepted) << (verdict.reasons.empty() ? "" : verdict.reasons.front());
}

TEST(GreyBoxFit, RejectsFrictionThatTheRecordDoesNotShow) {
  const Model plant = truth(friction_kind(), {0.2, 0.4, 1e-12}, 0.1);
  const FitResult result = fitted(record_of(plant, 0.02, -3.0, 3.0, 0.01, 2), "friction");
  EXPECT_LT(named(result.model, "friction").lower95, 0.0);
  EXPECT_FALSE(judge(result.model, {}).accepted);
}

TEST(GreyBoxFit, FindsTanksThatEmpty) {
  Model plant = truth(outflow_kind(), {0.05, 60.0, 45.0, 4.0}, -2.0);
  plant.initial_state = {0.5, -0.4};
  const Record record = record_of(plant, 4.0, 0.8, 3.2, 0.005, 3);
  const FitResult result = fitted(record, "outflow");
  EXPECT_LT(std::sqrt(result.model.estimation->score.mse), 0.0055);
  EXPECT_LT(std::sqrt(result.model.validation->score.mse), 0.0065);
  EXPECT_TRUE(named(result.model, "input_bias").fixed);
  // About another input the same tanks have another linear form: their orifices are the same.
  const auto orifice = [](const Model& model) {
    const std::vector<double>& v = model.grey_box->values;
    return 2.0 * std::sqrt(v[3]) / v[2];
  };
  EXPECT_NEAR(orifice(result.model), orifice(plant), 0.02 * orifice(plant));
}

FitResult fitted_below(const Record& record, std::optional<double> most_mse, const std::vector<Model>& known = {}) {
  const StructureOptions asked{.name = "friction", .structure = structure_family("friction").make({})};
  return fit(record, asked, {.intervals = IntervalMethod::straight, .most_mse = most_mse}, run_in_order, known);
}

TEST(GreyBoxFit, GivesUpOnlyWhereNoModelComesBelowTheErrorThatIsWanted) {
  const Record record = record_of(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1), 0.02, -3.0, 3.0, 0.002, 1);
  const FitResult any = fitted_below(record, {});
  const double least = any.model.estimation->score.mse;
  for (const double times : {1.0001, 4.0, 1000.0}) {
    const FitResult found = fitted_below(record, times * least);
    EXPECT_NEAR(found.model.estimation->score.mse, least, 1e-7 * least) << times;
    EXPECT_LE(found.model.estimation->evaluations, any.model.estimation->evaluations) << times;
  }
  for (const double times : {0.9, 0.5, 0.01})
    EXPECT_THROW((void)fitted_below(record, times * least), DataError) << times;
}

TEST(GreyBoxFit, StartsFromAKnownLinearForm) {
  const Record record = record_of(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1), 0.02, -3.0, 3.0, 0.002, 1);
  const FitResult alone = fitted_below(record, {});
  const Model linear = fitted(record, "integrator_lag").model;
  const FitResult found = fitted_below(record, {}, {linear});
  EXPECT_EQ(found.work.count("search"), 0U) << "the linear form is fitted again";
  EXPECT_NEAR(found.model.estimation->score.mse, alone.model.estimation->score.mse,
              1e-6 * alone.model.estimation->score.mse);
}

TEST(GreyBoxFit, HoldsOnAnotherRecordOfItsTanksThatBeginsElsewhere) {
  const Model plant = truth(outflow_kind(), {0.05, 60.0, 45.0, 4.0}, -2.0);
  const FitResult result = fitted(record_of(plant, 4.0, 0.8, 3.2, 0.005, 3), "outflow");
  for (const std::vector<double>& state : {std::vector<double>{1.5, 2.0}, {-2.0, -2.5}}) {
    Model elsewhere = plant;
    elsewhere.initial_state = state;
    const ValidationReport report = validate(result.model, record_of(elsewhere, 4.0, 1.2, 3.2, 0.005, 8), {});
    EXPECT_LT(std::sqrt(report.score.mse), 0.008);
    EXPECT_FALSE(report.end_stop);
  }
}

TEST(GreyBoxModel, BeginsAtRestUnderAnInputThatIsNamed) {
  for (const GreyBoxKind* kind : {&outflow_kind(), &overflow_kind()}) {
    std::vector<double> values{0.05, 60.0, 45.0, 4.0};
    if (kind == &overflow_kind()) values.insert(values.end(), {2.0, 2.5, 0.6});
    const Model plant = truth(*kind, values, -2.0);
    for (const double level : {0.0, 1.0, 2.0, 2.6, 4.5}) {
      const Model begun = begun_at(plant, level);
      const Eigen::VectorXd output = simulate(begun, Eigen::VectorXd::Constant(100, level), 4.0);
      EXPECT_LT(output.maxCoeff() - output.minCoeff(), 1e-6) << level;
    }
    EXPECT_NEAR(begun_at(plant, 2.0).initial_state[0], 0.0, 1e-9);
    EXPECT_TRUE(begins_at_a_level(plant));
  }
  EXPECT_FALSE(begins_at_a_level(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.0)));
}

TEST(GreyBoxFit, HoldsATankThatIsTooFastForTheRecord) {
  for (int seed = 1; seed <= 3; ++seed) {
    const Model plant = truth(outflow_kind(), {0.05, 0.04, 45.0, 4.0}, -2.0);
    const FitResult result = fitted(record_of(plant, 4.0, 0.8, 3.2, 0.005, seed), "outflow");
    const ParameterEstimate upper = named(result.model, "upper_s");
    EXPECT_NEAR(upper.value, 0.04, upper.fixed ? 1e-9 : 4.0 * upper.std) << "a hundredth of a row";
    EXPECT_LT(upper.value, 0.4);
    EXPECT_FALSE(named(result.model, "lower_s").fixed);
    EXPECT_LT(std::sqrt(result.model.validation->score.mse), 0.0065);
    EXPECT_TRUE(judge(result.model, {}).accepted);
  }
}

TEST(GreyBoxFit, FindsTheGainOfOneTankByItself) {
  // One tank, by small steps, on rows of 5 s; its inflow stops at times, and it runs empty.
  PortableDraw draw(5);
  Record record;
  record.step_s = 5.0;
  record.input.resize(1200);
  record.output.resize(1200);
  double x = 4.0;
  for (Eigen::Index k = 0; k < 1200; ++k) {
    record.input[k] = k % 18 != 0 ? record.input[k - 1] : std::max(0.0, 0.35 * draw.uniform() - 0.08);
    record.output[k] = x + 0.01 * draw.normal();
    for (int step = 0; step < 500; ++step) x = std::max(0.0, x + 0.01 * (record.input[k] - 0.05 * std::sqrt(x)));
  }
  const FitResult result = fitted(record, "outflow");
  const ParameterEstimate& gain = named(result.model, "gain");
  EXPECT_NEAR(gain.value, 1.0, 2e-3);
}

TEST(GreyBoxFit, FindsTanksThatOverflow) {
  const Model plant = truth(overflow_kind(), {0.05, 60.0, 45.0, 4.0, 2.0, 2.5, 0.6}, -2.0);
  const FitResult result = fitted(record_of(plant, 4.0, 0.5, 4.5, 0.005, 4), "overflow");
  EXPECT_LT(std::sqrt(result.model.validation->score.mse), 0.01);
  EXPECT_NEAR(result.model.grey_box->values[6], 0.6, 0.05);
}

TEST(GreyBoxFit, FindsTheDeadTimeAlsoFromAKnownModelWithoutOne) {
  Model plant = truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1);
  plant.transfer_function.delay_s = 0.07;
  const Record record = record_of(plant, 0.02, -3.0, 3.0, 0.002, 8);
  StructureOptions asked{.name = "friction", .structure = structure_family("friction").make({})};
  const FitResult without = fit(record, asked, {});
  asked.structure.delay.freedom = Freedom::free;
  for (const std::vector<Model>& known : {std::vector<Model>{}, std::vector<Model>{without.model}}) {
    const FitResult result = fit(record, asked, {}, run_in_order, known);
    EXPECT_NEAR(result.model.transfer_function.delay_s, 0.07, 0.002) << known.size();
    expect_found(result.model, "friction", 0.5, 0.02);
  }
}

TEST(GreyBoxFit, HoldsWhatIsAskedAndRefusesWhatMakesNoSense) {
  const Record record = record_of(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1), 0.02, -3.0, 3.0, 0.002, 5);
  const FitResult result = fitted(record, "friction", {{"friction", true, 0.3, {}, {}}});
  EXPECT_EQ(result.model.grey_box->values[2], 0.3);
  EXPECT_TRUE(named(result.model, "friction").fixed);
  EXPECT_THROW((void)fitted(record, "friction", {{"a2", true, 0.3, {}, {}}}), ConfigError);
  EXPECT_THROW((void)fitted(record, "friction", {{"friction", {}, {}, 0.0, 1.0}}), ConfigError);
  EXPECT_THROW((void)structures::behind_valve(structures::grey_box(friction_kind())), ConfigError);
}

TEST(GreyBoxModel, IsTheSameAfterItsFile) {
  const Record record = record_of(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.1), 0.02, -3.0, 3.0, 0.002, 6);
  Model model = fitted(record, "friction").model;
  model.verdict = judge(model, {});
  const std::string text = to_text(model);
  const Model read = model_from_text(text, "friction.json");
  EXPECT_EQ(to_text(read), text);
  EXPECT_EQ((simulate(read, record.input, 0.02) - simulate(model, record.input, 0.02)).cwiseAbs().maxCoeff(), 0.0);
  ASSERT_TRUE(read.structure && read.structure->structure.grey_box);
  EXPECT_EQ(read.structure->structure.grey_box->kind, &friction_kind());
}

TEST(GreyBoxModel, TakesItsLinearFormFromItsValues) {
  const std::string text =
      R"({"grey_box": {"kind": "friction", "gain": 0.2, "lag_s": 0.4, "friction": 0.5},
          "transfer_function": {"numerator": [{"coefficient": 9, "order": 0}],
                                "denominator": [{"coefficient": 1, "order": 1}], "delay_s": 0.1}})";
  const Model model = model_from_text(text, "m.json");
  EXPECT_EQ(model.transfer_function.numerator[0].coefficient, 0.2);
  EXPECT_EQ(model.transfer_function.denominator[0].coefficient, 0.4);
  EXPECT_EQ(model.transfer_function.delay_s, 0.1);
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    EXPECT_THROW((void)model_from_text(changed, "m.json"), ConfigError) << to;
  };
  refused("\"friction\", ", "\"stiction\", ");
  refused("0.4", "-0.4");
  refused("\"lag_s\": 0.4, ", "");
  refused("\"lag_s\"", "\"lag\"");
}

TEST(GreyBoxModel, IsLateByItsDelay) {
  Model model = truth(friction_kind(), {0.2, 0.4, 0.5}, 0.0);
  const Record record = record_of(model, 0.02, -3.0, 3.0, 0.0, 7, 300);
  model.transfer_function.delay_s = 0.06;
  const Eigen::VectorXd late = simulate(model, record.input, 0.02);
  EXPECT_NEAR((late.tail(297) - record.output.head(297)).cwiseAbs().maxCoeff(), 0.0, 1e-12);
  model.transfer_function.delay_s = 0.07;  // half a row more: between its neighbours
  const Eigen::VectorXd between = simulate(model, record.input, 0.02);
  const Eigen::VectorXd middle = 0.5 * (late.tail(296) + late.segment(3, 296));
  EXPECT_NEAR((between.tail(296) - middle).cwiseAbs().maxCoeff(), 0.0, 1e-3);
}

TEST(GreyBoxModel, IsExportedNowhere) {
  EXPECT_THROW((void)exported(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.0), {}), ConfigError);
  EXPECT_THROW((void)simulate(truth(friction_kind(), {0.2, 0.4, 0.5}, 0.0), Eigen::VectorXd::Ones(5), 0.1,
                              SimulationMethod::gl1),
               ConfigError);
}

TEST(GreyBoxModel, IsTriedWhereItsLinearFormIsTheModel) {
  const auto model = [](std::vector<Term> denominator) {
    Model m;
    m.transfer_function = {{{1.0, 0.0}}, std::move(denominator), 0.0};
    m.stability.emplace();
    m.stability->stable = true;
    return m;
  };
  const Model integrating = model({{0.3, 2.0}, {1.0, 1.0}, {0.0, 0.0}});
  const Model lags = model({{0.2, 2.0}, {1.0, 1.0}, {1.0, 0.0}});
  const Model resonance = model({{0.3, 2.0}, {1.0, 1.0}, {1.0, 0.0}});
  const Model fractional = model({{1.0, 0.9}, {1.0, 0.0}});
  EXPECT_TRUE(is_linear_form_of(friction_kind(), integrating));
  EXPECT_FALSE(is_linear_form_of(friction_kind(), lags));
  EXPECT_TRUE(is_linear_form_of(outflow_kind(), lags));
  EXPECT_FALSE(is_linear_form_of(outflow_kind(), integrating));
  EXPECT_FALSE(is_linear_form_of(outflow_kind(), resonance));
  EXPECT_FALSE(is_linear_form_of(overflow_kind(), fractional));
}

}  // namespace
}  // namespace eha::ident
