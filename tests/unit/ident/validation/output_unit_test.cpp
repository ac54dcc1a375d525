// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/output_unit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "ident/model/model_output.hpp"
#include "ident/validation/input_unit.hpp"

namespace eha::ident {
namespace {

constexpr double kMillimetres = 25.4;

Model model_in_inches() {
  Model model;
  model.transfer_function = {{{0.5, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {0.3, 0.0}}, 0.0};
  model.input_bias = 0.1;
  model.initial_output = 3.0;
  model.initial_state = {0.2, -0.05};
  model.parameters = {{.name = "K",
                       .value = 0.5,
                       .std = 0.01,
                       .lower95 = 0.48,
                       .upper95 = 0.52,
                       .role = ParameterRole::numerator_coefficient},
                      {.name = "a2", .value = 0.2, .std = 0.01, .role = ParameterRole::denominator_coefficient}};
  model.validation.emplace().score = {.mse = 0.04, .error_min = -0.5, .error_max = 0.4};
  model.bode.emplace();
  model.bode->frequency_Hz = {1.0};
  model.bode->gain_dB = {-6.0};
  model.verdict = Verdict{.reasons = {"A sentence of the file, 0.5 in."},
                          .criteria = {{CriterionKind::max_abs_error, "validation", 0.5, 0.25, false},
                                       {CriterionKind::order_error, "n2", 0.1, 0.5, true},
                                       {CriterionKind::coefficient_interval, "K", 0.48, 0.0, true},
                                       {CriterionKind::coefficient_interval, "a2", 0.1, 0.0, true}}};
  return model;
}

TEST(OutputUnit, ScalesTheSimulatedOutput) {
  const Model inches = model_in_inches();
  const Model millimetres = in_output_unit(inches, "mm", kMillimetres);
  const Eigen::VectorXd input = Eigen::VectorXd::LinSpaced(200, -1.0, 2.0);
  const Eigen::VectorXd a = simulate(inches, input, 0.05, SimulationMethod::exact);
  const Eigen::VectorXd b = simulate(millimetres, input, 0.05, SimulationMethod::exact);
  EXPECT_LT((b - kMillimetres * a).cwiseAbs().maxCoeff(), 1e-9 * b.cwiseAbs().maxCoeff());
  EXPECT_EQ(millimetres.output_unit, "mm");
}

TEST(OutputUnit, ScalesScoresIntervalsAndTheBodePlot) {
  const Model shown = in_output_unit(model_in_inches(), "mm", kMillimetres);
  EXPECT_DOUBLE_EQ(shown.parameters[0].upper95, 0.52 * kMillimetres);
  EXPECT_DOUBLE_EQ(shown.parameters[1].value, 0.2);
  EXPECT_DOUBLE_EQ(shown.validation->score.mse, 0.04 * kMillimetres * kMillimetres);
  EXPECT_DOUBLE_EQ(shown.validation->score.error_min, -0.5 * kMillimetres);
  EXPECT_DOUBLE_EQ(shown.bode->gain_dB[0], -6.0 + 20.0 * std::log10(kMillimetres));
  EXPECT_DOUBLE_EQ(shown.verdict->criteria[0].limit, 0.25 * kMillimetres);
  EXPECT_DOUBLE_EQ(shown.verdict->criteria[1].limit, 0.5);
  EXPECT_DOUBLE_EQ(shown.verdict->criteria[2].value, 0.48 * kMillimetres);
  EXPECT_DOUBLE_EQ(shown.verdict->criteria[3].value, 0.1);
}

TEST(OutputUnit, BuildsTheSentencesInTheShownUnit) {
  const Model shown = in_output_unit(model_in_inches(), "mm", kMillimetres);
  EXPECT_EQ(shown.verdict->reasons,
            std::vector<std::string>{
                "The model is too far off at one place: the greatest validation error of 12.7 mm is above the "
                "limit of 6.35 mm; look there in the report, and cut a disturbance with --from or --to."});
  Model without = model_in_inches();
  without.verdict->criteria.clear();
  EXPECT_EQ(in_output_unit(without, "mm", kMillimetres).verdict->reasons[0], "A sentence of the file, 0.5 in.")
      << "of a file without criteria the sentence is all there is";
}

TEST(InputUnit, KeepsTheOutputOfTheSameInput) {
  constexpr double kMillivolts = 1000.0;
  Model volts = model_in_inches();
  volts.past_input = {{-0.5, 0.0, 0.3}};
  Model valve = volts;
  valve.input_bias = 0.0;
  valve.input_map = ValveMap{0.1, 0.2, 0.9};
  const Eigen::VectorXd input = Eigen::VectorXd::LinSpaced(200, -1.0, 2.0);
  for (const Model& model : {volts, valve}) {
    const Model converted = in_input_unit(model, "mV", kMillivolts);
    const Eigen::VectorXd a = simulate(model, input, 0.05, SimulationMethod::exact);
    const Eigen::VectorXd b = simulate(converted, kMillivolts * input, 0.05, SimulationMethod::exact);
    EXPECT_LT((b - a).cwiseAbs().maxCoeff(), 1e-9 * a.cwiseAbs().maxCoeff());
    EXPECT_DOUBLE_EQ(converted.parameters[0].upper95, 0.52 / kMillivolts);
    EXPECT_DOUBLE_EQ(converted.bode->gain_dB[0], -66.0);
    EXPECT_EQ(converted.input_unit, "mV");
  }
}

}  // namespace
}  // namespace eha::ident
