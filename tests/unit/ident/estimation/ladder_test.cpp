// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/ladder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "ident/estimation/ladder_fits.hpp"
#include "ident/estimation/sub_structures.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

Climb climbed(const Record& record, const LadderOptions& wanted = {}, const FitOptions& fit_options = {}) {
  const PreparedRecord prepared(record, {});
  return climb(prepared, wanted, fit_options, {},
               [&](const StructureOptions& asked, const FitOptions& options, const std::vector<Model>& known) {
                 return fit(prepared, asked, options, run_in_order, known);
               });
}

const Model* model_named(const Climb& found, const std::string& name) {
  for (const ClimbedModel& model : found.models) {
    if (model.result.model.name == name) return &model.result.model;
  }
  return nullptr;
}

Model integrating_behind_valve() {
  Model model;
  model.transfer_function = {{{0.13, 0.0}}, {{0.25, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  model.input_map = ValveMap{-0.2, 0.3, 0.85};
  return model;
}

TEST(Ladder, FindsAnIntegratorBehindAValve) {
  const Climb found = climbed(record_of(integrating_behind_valve(), 0.05, 0.002, 5));
  EXPECT_EQ(found.recommendation.model, "integrator_lag_valve") << sentence(found.recommendation);
  const Model* model = model_named(found, "integrator_lag_valve");
  ASSERT_NE(model, nullptr);
  EXPECT_TRUE(model->verdict->accepted);
  EXPECT_EQ(model->stability->integrator_order, 1.0);
  EXPECT_NEAR(model->input_map->null, -0.2, 0.02);
  EXPECT_NEAR(model->input_map->dead_band, 0.3, 0.02);
  for (const char* name : {"io", "fo"}) EXPECT_NE(model_named(found, name), nullptr) << "is always there";
}

TEST(LadderFits, PrefersAStructureThatErrsClearlyLessWhateverNoiseModelPredictsTheErrorOfTheOther) {
  const auto with = [](double rms, double ar_bic) {
    ClimbedModel climbed;
    climbed.result.model.transfer_function = {{{0.15, 0.0}}, {{1.0, 1.0}, {0.0, 0.0}}, 0.0};
    EstimationReport& estimation = climbed.result.model.estimation.emplace();
    estimation.score.mse = rms * rms;
    estimation.score.r2_percent = 99.9;
    estimation.information.emplace().ar_bic = ar_bic;
    return climbed;
  };
  const FitOptions options;
  const LadderLimits limits;
  const FitStructure none;
  const LadderFits fits(options, limits, none);
  const ClimbedModel integrator = with(0.00169, -6575.0);
  EXPECT_FALSE(fits.is_preferred(integrator, with(0.0005, -6573.0)));
  EXPECT_TRUE(fits.is_preferred(with(0.0005, -6573.0), integrator));
  EXPECT_TRUE(fits.is_preferred(integrator, with(0.0016, -6573.0)));
  EXPECT_FALSE(fits.is_preferred(with(0.0016, -6573.0), integrator));
}

/// Levels of random height, each held for 0.2 s to 1.2 s, with white noise on the output.
Record moved_by_levels(const Model& plant, double noise, std::uint64_t seed) {
  Record record;
  record.step_s = 0.04;
  record.input.resize(700);
  std::mt19937_64 draw(seed);
  for (Eigen::Index k = 0; k < record.input.size();) {
    const double level = 6.0 * uniform(draw) - 3.0;
    const auto end = std::min(record.input.size(), k + 5 + static_cast<Eigen::Index>(25.0 * uniform(draw)));
    while (k < end) record.input[k++] = level;
  }
  record.output = simulate(plant, record.input, record.step_s);
  const double spread = std::sqrt((record.output.array() - record.output.mean()).square().mean());
  for (double& y : record.output) y += noise * spread * normal(draw);
  return record;
}

TEST(Ladder, FindsTheIntegratorBeforeAResonanceOfACylinder) {
  Model plant;
  plant.transfer_function = {{{0.6, 0.0}}, {{0.028, 3.0}, {0.05, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  const Climb found = climbed(moved_by_levels(plant, 0.002, 10));
  EXPECT_EQ(found.recommendation.model, "cylinder") << sentence(found.recommendation);
  const Model* model = model_named(found, "cylinder");
  ASSERT_NE(model, nullptr);
  EXPECT_NEAR(value(*model, "a3"), 0.028, 1e-3);
  EXPECT_NEAR(value(*model, "a2"), 0.05, 1e-2);
  EXPECT_EQ(model->stability->integrator_order, 1.0);
}

TEST(Ladder, LeavesAZeroOutThatOnlyTheProfileOfADeadTimeShowsToBeNone) {
  Model plant;
  plant.transfer_function = {{{2.0, 0.0}}, {{0.2326, 2.0}, {0.1929, 1.0}, {1.0, 0.0}}, 0.04};
  for (const unsigned seed : {1U, 5U}) {
    Record record;
    record.step_s = 0.02;
    record.input = Eigen::VectorXd::Zero(3000);
    std::mt19937_64 draw(seed);
    for (const double f_Hz : {0.05, 0.15, 0.25, 0.45, 0.65, 1.05, 1.55}) {
      const double phase = 6.28 * uniform(draw);
      for (Eigen::Index k = 0; k < record.input.size(); ++k) {
        record.input[k] += std::sin(6.2832 * f_Hz * record.step_s * static_cast<double>(k) + phase);
      }
    }
    record.output = simulate(plant, record.input, record.step_s);
    for (double& y : record.output) y += 0.0015 * normal(draw);
    const Climb found = climbed(record);
    EXPECT_EQ(found.recommendation.model, "io") << seed << ": " << sentence(found.recommendation);
  }
}

TEST(Ladder, FindsTheTwoPolesThatADeadTimeStoodFor) {
  Model plant;  // a resonance of 9.5 Hz behind a lag of 12 ms
  plant.transfer_function = {
      {{18.0, 0.0}}, {{3.333e-6, 4.0}, {4.378e-4, 3.0}, {0.02533, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  plant.input_map = ValveMap{0.12, 0.25, 15.0 / 18.0};
  Record record;
  record.step_s = 0.01;
  record.input.resize(6000);
  std::mt19937_64 draw(2);
  double level = 0.0;
  for (Eigen::Index k = 0; k < record.input.size(); ++k) {
    if (k % 100 == 0) level = 0.12 + 2.4 * uniform(draw) - 1.2;
    record.input[k] = level;
  }
  record.output = simulate(plant, record.input, record.step_s);
  for (double& y : record.output) y += 0.01 * normal(draw);
  const Climb found = climbed(record);
  EXPECT_EQ(found.recommendation.model, "cylinder_valve") << sentence(found.recommendation);
  const Model* model = model_named(found, "cylinder_valve");
  ASSERT_NE(model, nullptr);
  EXPECT_NEAR(model->transfer_function.delay_s, 0.008, 0.002);
}

TEST(Ladder, SearchesRoughlyWhatCannotComeNearAndNeverItsAnswers) {
  Model plant;
  plant.transfer_function = {{{1.0, 0.0}}, {{0.5, 1.0}, {1.0, 0.0}}, 0.0};
  for (const IntervalMethod intervals : {IntervalMethod::profile, IntervalMethod::straight}) {
    const Climb found = climbed(moved_by_levels(plant, 0.01, 13), {}, {.intervals = intervals});
    EXPECT_EQ(found.recommendation.model, "io1") << sentence(found.recommendation);
    std::vector<std::string> rough;
    for (const ClimbedModel& model : found.models) {
      const std::string& name = model.result.model.name;
      EXPECT_EQ(model.is_rough, model.result.model.provenance.contains("search")) << name;
      if (!model.is_rough) continue;
      rough.push_back(name);
      EXPECT_NE(name, found.recommendation.model);
      EXPECT_NE(name, found.recommendation.runner_up);
    }
    EXPECT_EQ(rough, (std::vector<std::string>{"integrator_lag_valve", "cylinder_valve"}));
  }
}

TEST(Ladder, FindsAZeroBesideTwoPolesInEitherHalfPlane) {
  for (const double zero : {0.9, -0.5}) {
    Model plant;
    plant.transfer_function = {{{zero, 1.0}, {1.0, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.8, 0.0}}, 0.0};
    const Climb found = climbed(moved_by_levels(plant, 0.01, 11));
    EXPECT_EQ(found.recommendation.model, "io") << sentence(found.recommendation);
    const Model* model = model_named(found, "io");
    ASSERT_NE(model, nullptr);
    EXPECT_NEAR(value(*model, "b1"), zero, 0.05);
    EXPECT_NEAR(value(*model, "b0"), 1.0, 0.05);
  }
}

TEST(Ladder, FindsAnIntegratorWithDeadTime) {
  Model plant;
  plant.transfer_function = {{{0.6, 0.0}}, {{1.0, 1.0}, {0.0, 0.0}}, 0.3};
  const Climb found = climbed(moved_by_levels(plant, 0.005, 12));
  EXPECT_EQ(found.recommendation.model, "integrator_lag") << sentence(found.recommendation);
  const Model* model = model_named(found, "integrator_lag");
  ASSERT_NE(model, nullptr);
  EXPECT_NEAR(model->transfer_function.delay_s, 0.3, 0.01);
  EXPECT_EQ(model->transfer_function.denominator.size(), 2U);
}

TEST(Ladder, LeavesOutACoefficientThatIsCompatibleWith0) {
  // An integrator of order 0.8 before a lag, which no rung has.
  const Climb found = climbed(moved_by_levels(fractional(0.3, 1.7, 0.8, 0.0, 0.7), 0.005, 13));
  EXPECT_EQ(found.recommendation.model, "fo") << sentence(found.recommendation);
  const Model* model = model_named(found, "fo");
  ASSERT_NE(model, nullptr);
  EXPECT_EQ(value(*model, "a0"), 0.0);
  EXPECT_NEAR(value(*model, "n1"), 0.8, 0.05);
}

TEST(Ladder, FindsAFractionalPlant) {
  const Climb found = climbed(record_of(fractional(0.5, 1.6, 0.8, 0.3, 1.0), 0.05, 0.002, 6));
  EXPECT_EQ(found.recommendation.model, "fo") << sentence(found.recommendation);
  EXPECT_FALSE(found.recommendation.runner_up.empty());
}

TEST(Ladder, JudgesEveryModelByThePartThatDoesNotEstimate) {
  const Climb found = climbed(record_of(fractional(0.5, 1.6, 0.8, 0.3, 1.0), 0.05, 0.002, 6));
  for (const ClimbedModel& climbed : found.models) {
    const Model& model = climbed.result.model;
    ASSERT_TRUE(model.validation) << model.name;
    EXPECT_TRUE(model.bode) << model.name;
    EXPECT_TRUE(model.estimation->noise) << model.name;
    EXPECT_EQ(climbed.result.simulated.size(), climbed.result.measured.size()) << model.name;
    const auto& criteria = model.verdict.value().criteria;
    EXPECT_TRUE(std::any_of(criteria.begin(), criteria.end(), [](const Criterion& c) {
      return c.parameter == "validation";
    })) << model.name;
  }
}

TEST(Ladder, SearchesFromFewStarts) {
  const Climb found = climbed(record_of(fractional(0.5, 1.6, 0.8, 0.3, 1.0), 0.05, 0.002, 6));
  const Work work = total(found.work);
  EXPECT_LT(work.local_searches, 200U);
  EXPECT_LT(work.evaluations, 1900U);
}

TEST(Ladder, FindsADelayWhereThereIsOne) {
  Model plant = fractional(0.3, 2.0, 1.0, 0.6, 1.0);
  plant.transfer_function.delay_s = 0.32;
  const Climb found = climbed(record_of(plant, 0.05, 0.005, 7));
  EXPECT_EQ(found.recommendation.model, "io") << sentence(found.recommendation);
  const Model* model = model_named(found, "io");
  ASSERT_NE(model, nullptr);
  EXPECT_NEAR(model->transfer_function.delay_s, 0.32, 0.01);
  // Without one only a model that lacks a pole may have a delay in its place.
  plant.transfer_function.delay_s = 0.0;
  const Climb without = climbed(record_of(plant, 0.05, 0.005, 7));
  EXPECT_EQ(without.recommendation.model, "io") << sentence(without.recommendation);
  EXPECT_EQ(model_named(without, "io")->transfer_function.delay_s, 0.0);
}

TEST(Ladder, LeavesOutTheMapThatARecordDoesNotAllowAndSaysWhy) {
  Record record = record_of(fractional(0.3, 2.0, 1.0, 0.6, 1.0), 0.05, 0.005, 8);
  Model plant;
  plant.transfer_function = {{{1.0, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.6, 0.0}}, 0.0};
  // Always on one side of any dead band.
  record.input.array() += 6.0;
  plant.input_map = ValveMap{0.0, 0.5, 1.0};
  record.output = simulate(plant, record.input, record.step_s);
  const Climb found = climbed(record);
  EXPECT_NE(model_named(found, "io"), nullptr);
  ASSERT_FALSE(found.refused.empty());
  EXPECT_NE(found.refused.front().model.find("_valve"), std::string::npos);
  EXPECT_NE(found.refused.front().reason.find("dead band"), std::string::npos) << found.refused.front().reason;
}

TEST(Ladder, KeepsToWhatIsWantedOfItsStructures) {
  const Record record = record_of(fractional(0.3, 2.0, 1.0, 0.6, 1.0), 0.05, 0.005, 9);
  LadderOptions wanted;
  wanted.input_map = &input_map_kinds().front();
  wanted.parameters = {{"n2", true, 2.0, {}, {}}};
  wanted.delay = Structure().delay;
  wanted.io = {3, 1};
  const Climb found = climbed(record, wanted);
  for (const ClimbedModel& m : found.models) EXPECT_FALSE(m.result.model.input_map) << m.result.model.name;
  EXPECT_EQ(value(*model_named(found, "fo"), "n2"), 2.0);
  EXPECT_EQ(model_named(found, "io")->transfer_function.denominator.size(), 4U);
  wanted.parameters = {{"n7", true, 2.0, {}, {}}};
  EXPECT_THROW(static_cast<void>(climbed(record, wanted)), ConfigError);
}

TEST(Ladder, ThrowsWhatTheFirstStructureSaysOfABadRecord) {
  Record record = record_of(fractional(0.3, 2.0, 1.0, 0.6, 1.0), 0.05, 0.005, 9);
  record.output.setZero();
  EXPECT_THROW(static_cast<void>(climbed(record)), DataError);
}

std::vector<std::size_t> denominator_terms(const std::vector<StructureOptions>& all) {
  std::vector<std::size_t> terms;
  for (const StructureOptions& asked : all) terms.push_back(asked.structure.denominator.size());
  return terms;
}

TEST(SubStructures, LackOneFreedom) {
  EXPECT_TRUE(sub_structures({.structure = structures::io1()}).empty());
  EXPECT_EQ(denominator_terms(sub_structures({.structure = structures::io()})), (std::vector<std::size_t>{2, 3}));
  // A pole less, a pole at 0, and a zero less.
  const auto of_io = sub_structures({.structure = structures::io({3, 1})});
  ASSERT_EQ(denominator_terms(of_io), (std::vector<std::size_t>{3, 4, 4}));
  EXPECT_EQ(of_io[1].structure.denominator.front().coefficient.value, 0.0);
  EXPECT_FALSE(is_estimated(of_io[1], of_io[1].structure.denominator.front().coefficient));
  EXPECT_EQ(of_io[2].structure.numerator.front().coefficient.key.name, "K");
  // Whole orders, and without the term of the highest order.
  const auto of_fo = sub_structures({.structure = structures::fo()});
  ASSERT_EQ(denominator_terms(of_fo), (std::vector<std::size_t>{3, 2}));
  EXPECT_TRUE(has_finite_state(of_fo[0].structure));
}

TEST(SubStructures, HoldWhatARequestFreesAndKeepItsBounds) {
  StructureOptions fo{.structure = structures::fo(), .parameters = {{"b0", false, {}, {}, {}}}};
  fo.structure.delay.freedom = Freedom::free;
  const auto inside = sub_structures(fo);
  ASSERT_GE(inside.size(), 2U);
  EXPECT_FALSE(is_estimated(inside[0], inside[0].structure.delay));
  EXPECT_TRUE(is_estimated(inside[0], inside[0].structure.numerator[0].order));
  EXPECT_FALSE(is_estimated(inside[1], inside[1].structure.numerator[0].order));
  // An order that must not be whole is not made so.
  const StructureOptions bounded{.structure = structures::lag(), .parameters = {{"n1", {}, {}, 0.3, 0.8}}};
  EXPECT_TRUE(sub_structures(bounded).empty());
}

}  // namespace
}  // namespace eha::ident
