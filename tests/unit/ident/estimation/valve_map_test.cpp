// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr ValveMap kMap{-0.2, 0.3, 0.85};

Model behind(Model model, const ValveMap& map) {
  model.input_map = map;
  return model;
}

Model second_order() {
  Model model;
  model.transfer_function = {{{0.46, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.2, 0.0}}, 0.0};
  model.initial_output = 1.5;
  return model;
}

StructureOptions valve(Structure structure) { return asked_for(structures::behind_valve(std::move(structure))); }

const ParameterEstimate& parameter(const Model& model, const std::string& name) {
  const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                               [&](const ParameterEstimate& p) { return p.name == name; });
  if (at == model.parameters.end()) throw DataError("no parameter " + name);
  return *at;
}

std::string refusal(const Record& record, const StructureOptions& asked) {
  try {
    (void)fit(record, asked, {});
  } catch (const Error& error) {
    return error.what();
  }
  return "fitted";
}

TEST(ValveMap, HasTheOneSideThatTheRecordHas) {
  // A pump that moves nothing below 0.3 of its command.
  Model pump = second_order();
  pump.input_map = ValveMap{0.0, 0.3, 1.0};
  Record record = record_of(pump, 0.05, 0.0, 1);
  std::mt19937_64 draw(2);
  for (Eigen::Index k = 0; k < record.input.size();) {
    const double level = std::max(0.0, 1.2 * uniform(draw) - 0.2);
    const auto end = std::min(record.input.size(), k + 5 + static_cast<Eigen::Index>(30.0 * uniform(draw)));
    while (k < end) record.input[k++] = level;
  }
  record.output = simulate(pump, record.input, record.step_s);
  for (double& y : record.output) y += 0.002 * normal(draw);
  const Model found = fit(record, valve(structures::io()), {}).model;
  EXPECT_EQ(found.input_map->null, 0.0);
  EXPECT_EQ(found.input_map->negative_gain_ratio, 1.0);
  EXPECT_NEAR(found.input_map->dead_band, 0.3, 0.01);
  EXPECT_TRUE(parameter(found, "null").fixed);
  EXPECT_NEAR(value(found, "K"), 0.46, 0.02);
  // It never was within the dead band.
  record.input = record.input.cwiseMax(0.4);
  record.input.head(2).setZero();
  EXPECT_NE(refusal(record, valve(structures::io())).find("record more input within the dead band"), std::string::npos);
}

TEST(ValveMap, IsZeroInsideTheBandAndHasAGainOnEitherSide) {
  Eigen::VectorXd u(7);
  u << -2.0, -0.45, -0.4, -0.2, 0.0, 0.05, 1.0;
  Eigen::VectorXd v(7);
  v << -1.275, 0.0, 0.0, 0.0, 0.0, 0.0, 0.9;
  EXPECT_LT((mapped(kMap, u) - v).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(is_above(kMap, u).sum(), 1.0);
  EXPECT_EQ(is_below(kMap, u).sum(), 1.0);
  // Without a band the sides meet at the null.
  EXPECT_LT((mapped({0.5, 0.0, 1.0}, u) - (u.array() - 0.5).matrix()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ValveMap, IsHonouredBySimulationAndComparison) {
  const Model model = behind(second_order(), kMap);
  const Eigen::VectorXd u = excitation(0.05);
  Model linear = second_order();
  const Eigen::VectorXd expected = simulate(linear, mapped(kMap, u), 0.05);
  EXPECT_LT((simulate(model, u, 0.05) - expected).cwiseAbs().maxCoeff(), 1e-12);
  const Record record = record_of(model, 0.05, 0.0, 1);
  EXPECT_LT(validate(model, record, {}).score.mse, 1e-16);
  EXPECT_GT(validate(linear, record, {}).score.mse, 1e-4);
}

struct DerivativeCase {
  std::string name;
  StructureOptions structure;
};

std::vector<DerivativeCase> derivative_cases() {
  DerivativeCase io{"io", valve(structures::io())};
  DerivativeCase moving{"io moving before", valve(structures::io({3, 0}))};
  moving.structure.initial_state = InitialState::estimated;
  DerivativeCase zeros{"io with zeros: the ratio is a coordinate", valve(structures::io({4, 2}))};
  DerivativeCase delayed{"fo with delay", valve(structures::fo())};
  delayed.structure.structure.delay.freedom = Freedom::free;
  delayed.structure.structure.delay.value = 0.0137;
  DerivativeCase excited{"fo with past input", valve(structures::fo())};
  excited.structure.initial_state = InitialState::estimated;
  DerivativeCase bounded{"ratio within bounds", valve(structures::fo())};
  bounded.structure.parameters = {{"negative_gain_ratio", {}, 0.8, 0.5, 2.0}};
  DerivativeCase held{"dead band held", valve(structures::fo())};
  held.structure.parameters = {{"dead_band", true, 0.25, {}, {}}};
  return {io, moving, zeros, delayed, excited, bounded, held};
}

/// The record averaged over blocks of four rows.
Record averaged(const Record& fine) {
  Record record = fine;
  record.step_s *= 4.0;
  record.input.resize(fine.input.size() / 4);
  record.output.resize(record.input.size());
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    record.input[k] = fine.input.segment(4 * k, 4).mean();
    record.output[k] = fine.output[4 * k];
  }
  return record;
}

TEST(ValveMap, HasDerivativesThatEqualCentralDifferences) {
  const Record record = record_of(behind(fractional(0.6, 1.75, 0.9, 0.04, 0.46), kMap), 0.01, 0.05, 1);
  const Record coarse = averaged(record);
  for (const int way : {0, 1, 2}) {  // every row, filtered rows, block means of the mapped input
    const Record& seen = way == 2 ? coarse : record;
    const Comparison comparison = compare_every(static_cast<std::size_t>(seen.input.size()), way == 1 ? 10 : 1, 0);
    for (const DerivativeCase& c : derivative_cases()) {
      ComparedRecord::Options options{.past = wants_past_input(c.structure), .guard = 2.0};
      if (way == 2) {
        options.fine_input = record.input;
        options.block = 4;
      }
      const ComparedRecord compared(seen, comparison, comparison.count, options);
      const Variant variant = variants(c.structure, compared.past().size(), false).front();
      const Parametrisation parametrisation = Parametrisation::search(c.structure, {50.0, 0.1, -5.0, 5.0});
      const OutputError problem(compared, parametrisation, variant.linear);
      const Eigen::VectorXd theta = parametrisation.start().array() + 0.01;
      auto point = problem.evaluate(theta);
      ASSERT_TRUE(point) << c.name;
      if (variant.linear.past_shared > 0) point->linear.initial_state.setLinSpaced(-1.0, 2.0);
      std::vector<ParameterKey> parameters;
      const Eigen::MatrixXd exact = problem.derivatives(theta, point->linear, parameters);
      ASSERT_EQ(exact.cols(), static_cast<Eigen::Index>(parameters.size()));
      std::size_t of_map = 0;
      for (Eigen::Index l = 0; l < exact.cols(); ++l) {
        const ParameterKey& key = parameters[static_cast<std::size_t>(l)];
        const bool shapes_the_map = key.role == ParameterRole::valve_null || key.role == ParameterRole::dead_band;
        if (!shapes_the_map && key.role != ParameterRole::negative_gain_ratio) continue;
        ++of_map;
        // So small a step carries no sample across an edge, and in between the map is straight.
        const double h = 1e-6;
        const auto at = [&](double shift) {
          Eigen::VectorXd moved = theta;
          LinearSolution linear = point->linear;
          (l < theta.size() ? moved[l] : linear.negative_gain_ratio) += shift;
          return problem.simulated(moved, linear);
        };
        const Eigen::VectorXd difference = (at(h) - at(-h)) / (2.0 * h);
        EXPECT_LT((exact.col(l) - difference).cwiseAbs().maxCoeff(), 1e-5 * difference.cwiseAbs().maxCoeff())
            << c.name << ", " << key.name << ", way " << way;
      }
      EXPECT_EQ(of_map, c.name == "dead band held" ? 2U : 3U) << c.name;
    }
  }
}

TEST(ValveMap, IsRecoveredFromItsOwnOutput) {
  for (const int decimation : {1, 4}) {
    FitOptions options;
    options.decimation = decimation;
    const Record record = record_of(behind(second_order(), kMap), 0.01, 0.0, 1);
    const FitResult result = fit(record, valve(structures::io()), options);
    EXPECT_NEAR(value(result.model, "null"), kMap.null, 1e-5);
    EXPECT_NEAR(value(result.model, "dead_band"), kMap.dead_band, 1e-5);
    EXPECT_NEAR(value(result.model, "negative_gain_ratio"), kMap.negative_gain_ratio, 1e-5);
    EXPECT_NEAR(value(result.model, "a2"), 0.3, 3e-5);
    EXPECT_NEAR(value(result.model, "K"), 0.46, 4.6e-5);
    EXPECT_EQ(result.model.input_bias, 0.0);
    EXPECT_EQ(result.model.provenance.count("input_bias"), 0U);
    EXPECT_GT(result.model.validation->score.r2_percent, 99.9999);
  }
}

TEST(ValveMap, IsRecoveredBeforeFractionalOrdersZerosAndAMovingStart) {
  const FitResult fractional_one =
      fit(record_of(behind(fractional(0.6, 1.75, 0.9, 0.04, 0.46), kMap), 0.02, 0.0, 1), valve(structures::fo()), {});
  EXPECT_NEAR(value(fractional_one.model, "dead_band"), kMap.dead_band, 1e-4);
  EXPECT_NEAR(value(fractional_one.model, "n2"), 1.75, 1e-4);

  Model zero = second_order();
  zero.transfer_function.numerator = {{0.2, 1.0}, {0.46, 0.0}};
  const FitResult with_zero = fit(record_of(behind(zero, kMap), 0.02, 0.0, 1), valve(structures::io({2, 1})), {});
  EXPECT_NEAR(value(with_zero.model, "null"), kMap.null, 1e-4);
  EXPECT_NEAR(value(with_zero.model, "negative_gain_ratio"), kMap.negative_gain_ratio, 1e-4);

  Model moving = second_order();
  moving.initial_state = {0.7, -0.1};
  const FitResult moved = fit(record_of(behind(moving, kMap), 0.02, 0.0, 1), valve(structures::io()), {});
  EXPECT_NEAR(value(moved.model, "dead_band"), kMap.dead_band, 1e-4);
  EXPECT_EQ(moved.model.initial_state.size(), 2U);
}

TEST(ValveMap, WithoutADeadBandEndsAtZeroOrWithinItsError) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    const Record record = record_of(behind(second_order(), {-0.2, 0.0, 0.85}), 0.05, 0.01, seed);
    FitOptions options;
    options.intervals = seed % 2 == 0 ? IntervalMethod::profile : IntervalMethod::straight;
    const FitResult result = fit(record, valve(structures::io()), options);
    const ParameterEstimate& dead_band = parameter(result.model, "dead_band");
    EXPECT_GE(dead_band.value, 0.0) << "seed " << seed;
    EXPECT_LE(dead_band.value, 4.0 * dead_band.std) << "seed " << seed;
    EXPECT_GE(dead_band.lower95, 0.0) << "seed " << seed;
    EXPECT_GT(dead_band.upper95, dead_band.value) << "seed " << seed;
    EXPECT_TRUE(result.model.estimation->converged) << result.model.estimation->termination << ", seed " << seed;
  }
}

TEST(ValveMap, IsRefusedWhereOneSideOfTheBandIsRare) {
  Record record = record_of(second_order(), 0.05, 0.0, 1);
  record.input = record.input.array().abs() + 0.1;
  record.output = simulate(behind(second_order(), {0.2, 0.05, 1.0}), record.input, 0.05);
  const std::string message = refusal(record, valve(structures::io()));
  EXPECT_NE(message.find("% of the samples that estimate lie below the dead band"), std::string::npos) << message;
  EXPECT_NE(message.find("at least 6 % on either side"), std::string::npos) << message;
}

TEST(ValveMap, TakesRequestsAndRefusesABias) {
  const Record record = record_of(behind(second_order(), kMap), 0.05, 0.001, 1);
  StructureOptions held = valve(structures::io());
  held.parameters = {{"null", true, -0.2, {}, {}}, {"negative_gain_ratio", true, 0.85, {}, {}}};
  const FitResult result = fit(record, held, {});
  EXPECT_TRUE(parameter(result.model, "null").fixed);
  EXPECT_EQ(result.model.input_map->negative_gain_ratio, 0.85);
  EXPECT_NEAR(value(result.model, "dead_band"), 0.3, 0.01);
  EXPECT_GT(parameter(result.model, "dead_band").std, 0.0);

  StructureOptions biased = valve(structures::io());
  biased.parameters = {{"input_bias", true, 0.1, {}, {}}};
  EXPECT_NE(refusal(record, biased).find("null, dead_band, negative_gain_ratio"), std::string::npos);
  FitOptions paper;
  paper.procedure = Procedure::paper;
  EXPECT_THROW((void)fit(record, valve(structures::io()), paper), ConfigError);
}

}  // namespace
}  // namespace eha::ident
