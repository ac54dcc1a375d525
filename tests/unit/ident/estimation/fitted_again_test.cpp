// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/delay_gain.hpp"
#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/moving_gain.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/estimation/valve_gain.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

Model two_poles(double delay_s) {
  Model plant = fractional(0.3, 2.0, 1.0, 0.6, 1.0);
  plant.transfer_function.delay_s = delay_s;
  return plant;
}

FitResult quickly_fitted(const PreparedRecord& prepared, const Structure& structure) {
  FitOptions options;
  options.intervals = IntervalMethod::straight;
  return fit(prepared, asked_for(structure), options);
}

TEST(WithProfiles, GivesTheIntervalsOfAFitWithProfiles) {
  const Record record = record_of(two_poles(0.0), 0.05, 0.02, 3);
  const PreparedRecord prepared(record, {});
  const FitResult quick = quickly_fitted(prepared, structures::io());
  const FitResult profiled = with_profiles(prepared, quick, {}, run_in_order);
  const FitResult whole = fit(prepared, asked_for(structures::io()), {});
  ASSERT_EQ(profiled.model.parameters.size(), whole.model.parameters.size());
  for (std::size_t i = 0; i < whole.model.parameters.size(); ++i) {
    const ParameterEstimate& a = profiled.model.parameters[i];
    const ParameterEstimate& b = whole.model.parameters[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.lower95, b.lower95) << a.name;
    EXPECT_EQ(a.upper95, b.upper95) << a.name;
  }
}

double predicted_gain(double delay_s, unsigned seed) {
  const Record record = record_of(two_poles(delay_s), 0.05, 0.02, seed);
  const PreparedRecord prepared(record, {});
  Work work;
  const double gain = predicted_delay_gain(prepared, *quickly_fitted(prepared, structures::io()).fitted, work);
  EXPECT_GT(work.jacobians, 0U);
  return gain;
}

TEST(PredictedDelayGain, TellsRecordsWithADelayFromOthers) {
  for (const unsigned seed : {3U, 4U, 5U}) {
    EXPECT_LT(predicted_gain(0.0, seed), 0.0) << "seed " << seed;
    // A short one and one that is longer than every delay tried.
    EXPECT_GT(predicted_gain(0.1, seed), 10.0) << "seed " << seed;
    EXPECT_GT(predicted_gain(1.0, seed), 10.0) << "seed " << seed;
  }
}

/// Of a record whose first rows are cut off.
double moving_gain(Eigen::Index cut, unsigned seed) {
  Record record = record_of(two_poles(0.0), 0.05, 0.02, seed);
  record.input = record.input.tail(record.input.size() - cut).eval();
  record.output = record.output.tail(record.output.size() - cut).eval();
  const PreparedRecord prepared(record, {});
  StructureOptions asked = asked_for(structures::io());
  asked.initial_state = InitialState::none;
  FitOptions options;
  options.intervals = IntervalMethod::straight;
  const FitResult at_rest = fit(prepared, asked, options);
  const LocalOptimum& rest = at_rest.fitted->optimum;
  asked.initial_state = InitialState::estimated;
  const Variant moving = variants(asked, 0, false).front();
  const OutputError problem(prepared.compared({}), rest.parametrisation, moving.linear);
  Work work;
  const double gain = highest_moving_gain(rest, problem, free_parameters(rest.parametrisation, moving.linear), work);
  EXPECT_EQ(work.jacobians, 1U);
  return gain;
}

TEST(HighestMovingGain, TellsRecordsCutInMotionFromOthers) {
  for (const unsigned seed : {3U, 4U, 5U}) {
    EXPECT_LT(moving_gain(0, seed), 0.0) << "seed " << seed;
    EXPECT_GT(moving_gain(137, seed), 30.0) << "seed " << seed;
  }
}

double predicted_map_gain(const std::optional<ValveMap>& map, unsigned seed) {
  Model plant = two_poles(0.0);
  plant.input_map = map;
  const Record record = record_of(plant, 0.05, 0.02, seed);
  const PreparedRecord prepared(record, {});
  const StructureOptions behind_map = asked_for(input_map_kinds().back().put_before(structures::io()));
  Work work;
  const double gain =
      predicted_valve_gain(prepared, *quickly_fitted(prepared, structures::io()).fitted, behind_map, work);
  EXPECT_GT(work.jacobians, 0U);
  return gain;
}

TEST(PredictedValveGain, TellsRecordsWithAMapFromOthers) {
  for (const unsigned seed : {3U, 4U, 5U}) {
    EXPECT_LT(predicted_map_gain(std::nullopt, seed), 15.0) << "seed " << seed;
    EXPECT_GT(predicted_map_gain(ValveMap{0.1, 0.3, 0.9}, seed), 20.0) << "seed " << seed;
  }
}

TEST(Nearest, EndsNearTheWholeSearchFromTheRightModelAtAFractionOfItsWork) {
  Model plant = two_poles(0.0);
  plant.input_map = ValveMap{0.1, 0.3, 0.9};
  const Record record = record_of(plant, 0.05, 0.02, 3);
  const PreparedRecord prepared(record, {});
  const std::vector<Model> known = {quickly_fitted(prepared, structures::io()).model};
  const StructureOptions behind_map = asked_for(input_map_kinds().back().put_before(structures::io()));
  FitOptions options;
  options.intervals = IntervalMethod::straight;
  options.search = Search::known;
  const FitResult whole = fit(prepared, behind_map, options, run_in_order, known);
  options.search = Search::nearest;
  const FitResult near = fit(prepared, behind_map, options, run_in_order, known);
  EXPECT_LT(near.model.estimation->score.mse, 1.02 * whole.model.estimation->score.mse);
  EXPECT_NEAR(near.model.input_map->dead_band, 0.3, 0.02);
  EXPECT_LT(3U * total(near.work).simulations(), 2U * total(whole.work).simulations());
}

TEST(Work, IsTheSameWhateverTheOrderOfTasks) {
  const Record record = record_of(two_poles(0.0), 0.05, 0.02, 3);
  const Executor backwards = [](std::size_t count, const std::function<void(std::size_t)>& task) {
    for (std::size_t i = count; i-- > 0;) task(i);
  };
  const FitResult a = fit(record, asked_for(structures::fo()), {});
  const FitResult b = fit(record, asked_for(structures::fo()), {}, backwards);
  EXPECT_EQ(a.work, b.work);
  EXPECT_GT(a.work.at("search").transforms, a.work.at("search").evaluations);
}

}  // namespace
}  // namespace eha::ident
