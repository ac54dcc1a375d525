// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/comparison.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/identify/scored_model.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/excitation/portable_draw.hpp"
#include "ident/fractional/simulate.hpp"
#include "tests/unit/identify/twin_source.hpp"

namespace eha::identify {
namespace {

using test::seeded;
using test::source_of;

/// integrator_lag_valve, fitted to a record.
ident::Model behind_valve(const Source& source) {
  ident::StructureOptions valve;
  valve.name = "integrator_lag_valve";
  valve.structure = ident::structures::behind_valve(ident::structures::integrator_lag());
  return ident::fit(source.record, valve, source.experiment->fit, thread_executor()).model;
}

TEST(Comparison, TellsNothingWhereASensorFroze) {
  Source frozen = source_of(seeded(2));
  EXPECT_EQ(compare_runs({source_of(seeded(1)), frozen}).runs[1].cannot_tell, "");
  frozen.frozen = "the output stays from 36 to 38.99 s";
  const std::string why = compare_runs({source_of(seeded(1)), frozen}).runs[1].cannot_tell;
  EXPECT_EQ(why.rfind("the sensor froze on ", 0), 0U) << why;
}

TEST(Comparison, NamesTheDeadBandThatChanged) {
  hal::SimOptions after = seeded(2);
  after.valve_dead_band_V = 0.25;
  const RunComparison comparison = compare_runs({source_of(seeded(1)), source_of(after)});
  ASSERT_TRUE(comparison.runs[1].change);
  const ident::PlantChange& change = *comparison.runs[1].change;
  ASSERT_TRUE(change.changed);
  EXPECT_EQ(change.parameters.front().name, "dead_band");
  EXPECT_NEAR(change.parameters.front().after - change.parameters.front().before, 0.10, 0.02);
  EXPECT_EQ(comparison.structure, "io_valve");
}

TEST(Comparison, KnowsTheBandOfEachModelAndThatOnlyTheNoiseGrew) {
  hal::SimOptions noisy = seeded(2);
  noisy.sensor_noise_V *= 15.0;
  const RunComparison comparison = compare_runs({source_of(seeded(1)), source_of(noisy)});
  for (const ComparedRun& run : comparison.runs) {
    ASSERT_TRUE(run.fit.model.verdict);
    ASSERT_TRUE(run.fit.model.verdict->usable_band);
    // Of the tones that were played, as the report of the run has it.
    EXPECT_NEAR(run.fit.model.verdict->usable_band->lowest_Hz, 0.05, 1e-9);
    EXPECT_NEAR(run.fit.model.verdict->usable_band->highest_Hz, 0.65, 1e-9);
  }
  const ComparedRun& grown = comparison.runs[1];
  EXPECT_FALSE(grown.change->changed);
  EXPECT_TRUE(grown.left_over.changed) << grown.left_over.before << " " << grown.left_over.after;
  EXPECT_GT(grown.left_over.after, grown.left_over.before);
}

TEST(Comparison, CallsAModelOfAnotherPlantThat) {
  const Source here = source_of(seeded(1));
  hal::SimOptions other = seeded(2);
  other.supply_pressure_bar = 90.0;
  const Source there = source_of(other);
  const ident::Model model = compare_runs({there, there}).runs[0].fit.model;
  const std::vector<ScoredModel> scored = score_models({model, compare_runs({here, here}).runs[0].fit.model}, here);
  EXPECT_GT(scored[0].validation.offset_reestimated.value_or(scored[0].validation.score).r2_percent, 90.0);
  EXPECT_TRUE(scored[0].of_another_plant);
  EXPECT_FALSE(scored[1].of_another_plant);
}

TEST(Comparison, CallsNoUnchangedRigAnotherPlantBecauseTheAmplitudesAreOthers) {
  const ident::Model model = behind_valve(source_of(seeded(1)));
  for (const double share : {0.5, 0.7}) {
    const ScoredModel unchanged = score_models({model}, source_of(seeded(2), share)).front();
    EXPECT_FALSE(unchanged.of_another_plant) << share;
    hal::SimOptions other = seeded(3);
    other.valve_dead_band_V += 0.04;
    EXPECT_TRUE(score_models({model}, source_of(other, share)).front().of_another_plant) << share;
  }
}

TEST(Comparison, NamesAnotherGainAsTheCauseOfAnError) {
  const ident::Model model = behind_valve(source_of(seeded(1)));
  EXPECT_FALSE(score_models({model}, source_of(seeded(2))).front().other_gain);
  hal::SimOptions faster = seeded(2);
  faster.valve_rated_flow_L_per_min *= 1.005;
  const ScoredModel scored = score_models({model}, source_of(faster)).front();
  ASSERT_TRUE(scored.other_gain);
  EXPECT_NEAR(scored.other_gain->ratio, 1.005, 0.001);
  const std::string told = other_gain_text(scored, 25.4, " mm");
  EXPECT_EQ(told.rfind("a gain 0.", 0), 0U) << told;
  EXPECT_NE(told.find(" mm rms: supply pressure"), std::string::npos) << told;
  hal::SimOptions rougher = seeded(2);
  rougher.sensor_noise_V *= 15.0;
  EXPECT_FALSE(score_models({model}, source_of(rougher)).front().other_gain) << "noise is no gain";
}

TEST(Comparison, CannotTellFromAShortRecordWhetherAStraightModelIsOfThisPlant) {
  const Source whole = source_of(seeded(1));
  ident::StructureOptions straight;
  straight.name = "io";
  straight.structure = ident::structures::io();
  ident::FitOptions options = whole.experiment->fit;
  options.split = 1.0;
  const ident::Model model = ident::fit(whole.record, straight, options, thread_executor()).model;
  Source part = source_of(seeded(2));
  // Three seconds, all on one side of the valve: the rod obeys another straight model there.
  part.record.input = part.record.input.head(3000).eval();
  part.record.output = part.record.output.head(3000).eval();
  part.experiment.reset();
  const ScoredModel scored = score_models({model}, part).front();
  EXPECT_FALSE(scored.of_another_plant);
  EXPECT_NE(scored.cannot_tell.find("record 30 s or more"), std::string::npos) << scored.cannot_tell;
  const ScoredModel on_all = score_models({model}, source_of(seeded(2))).front();
  EXPECT_EQ(on_all.cannot_tell, "");
  EXPECT_FALSE(on_all.of_another_plant);
}

TEST(Comparison, TellsALeakFromAnotherPlaceAlone) {
  const Source before = source_of(seeded(1));
  hal::SimOptions elsewhere = seeded(2);
  elsewhere.initial_displacement_in = 4.0;
  hal::SimOptions low = seeded(1);
  low.initial_displacement_in = 1.9;
  const RunComparison place = compare_runs({source_of(low), source_of(elsewhere)});
  EXPECT_TRUE(place.runs[1].change->changed) << "by the stiffness of the oil";
  EXPECT_NE(place.runs[1].cannot_tell.find("compare two runs about one place"), std::string::npos);
  elsewhere.leakage_cm3_per_s_per_bar = 0.1;
  elsewhere.initial_displacement_in = 3.3;
  const RunComparison leak = compare_runs({before, source_of(elsewhere)});
  EXPECT_TRUE(leak.runs[1].change->changed);
  EXPECT_EQ(leak.runs[1].cannot_tell, "") << leak.runs[1].first_model_error << " " << leak.runs[1].left_over.after;
  const auto says_places = [](const std::string& note) { return note.find("the records are about") != note.npos; };
  EXPECT_EQ(std::count_if(leak.notes.begin(), leak.notes.end(), says_places), 1);
}

TEST(Comparison, NamesTheRatioThatALoadChangedAndNoNullWithinWhatALeakShifts) {
  hal::SimOptions loaded = seeded(1);
  loaded.moving_mass_kg = 200.0;
  const RunComparison comparison = compare_runs({source_of(seeded(1)), source_of(loaded)});
  const ComparedRun& run = comparison.runs[1];
  ASSERT_TRUE(run.change && run.change->changed);
  for (const ident::ParameterChange& p : run.change->parameters) {
    EXPECT_TRUE(p.changed || p.name != "negative_gain_ratio");
    EXPECT_FALSE(p.changed && ident::is_of_dead_zone(p.role)) << p.name << " " << p.before << " " << p.after;
  }
  EXPECT_FALSE(run.bent_map) << "nothing of it is left to explain";
}

TEST(Comparison, SaysWhetherTheFirstModelHoldsOnTheSecondRecord) {
  const Source here = source_of(seeded(1));
  const RunComparison same = compare_runs({here, source_of(seeded(2))});
  EXPECT_TRUE(first_model_holds(same.runs[1])) << same.runs[1].first_model_error;
  EXPECT_GT(same.runs[1].first_model_error, 0.0);
  hal::SimOptions other = seeded(2);
  other.valve_dead_band_V = 0.25;
  const RunComparison changed = compare_runs({here, source_of(other)});
  EXPECT_FALSE(first_model_holds(changed.runs[1])) << changed.runs[1].first_model_error;
  EXPECT_GT(changed.runs[1].first_model_error, 2.0 * changed.runs[1].left_over.after);
}

TEST(Comparison, TellsASensorThatSlippedFromAnotherPlant) {
  const Source here = source_of(seeded(1));
  Source slipped = source_of(seeded(2));
  slipped.record.output.tail(slipped.record.output.size() / 2).array() += 0.3;
  for (const bool is_first : {false, true}) {
    const auto pair = is_first ? std::vector{slipped, here} : std::vector{here, slipped};
    const ComparedRun run = compare_runs(pair).runs[1];
    ASSERT_TRUE(run.sudden) << is_first;
    EXPECT_EQ(run.sudden->is_first, is_first);
    EXPECT_NEAR(run.sudden->jump.time_s, 20.0, 0.3);
    EXPECT_GT(run.sudden->jump.change, 0.1) << "what the fit to the record with the jump leaves of it";
    EXPECT_LT(run.sudden->jump.change, 0.35);
    EXPECT_LT(run.sudden->cut.to_s, 20.0);
    EXPECT_GT(run.sudden->cut.from_s, 20.0);
  }
  hal::SimOptions other = seeded(2);
  other.valve_dead_band_V = 0.25;
  EXPECT_FALSE(compare_runs({here, source_of(other)}).runs[1].sudden) << "another valve makes no jump";
}

TEST(Comparison, ClaimsNothingByAModelWithAGainOfTheOtherSignOrAMapThatIsOneWay) {
  const Source here = source_of(seeded(1));
  const ident::Model one = compare_runs({here, here}).runs[0].fit.model;
  EXPECT_FALSE(unfit_of(one, one));
  ident::Model other = one;
  other.transfer_function.numerator.front().coefficient *= -1.0;
  other.estimation->score.mse *= 1.1;
  ASSERT_TRUE(unfit_of(one, other));
  EXPECT_FALSE(unfit_of(one, other)->is_first);
  EXPECT_TRUE(unfit_of(other, one)->is_first);
  ident::Model shut = one;
  shut.input_map->negative_gain_ratio = 0.01;
  ASSERT_TRUE(unfit_of(one, shut));
  EXPECT_NE(unfit_of(one, shut)->why.find("one direction only"), std::string::npos);
  ident::Model poor = one;
  poor.estimation->score.mse *= 400.0;
  poor.estimation->score.fit_percent = 80.0;
  ASSERT_TRUE(unfit_of(one, poor));
  EXPECT_NE(unfit_of(one, poor)->why.find("20 times as much"), std::string::npos) << unfit_of(one, poor)->why;
}

/// A lag of levels, with a load that moves the output by itself: plain noise, or noise behind a lag of its own.
Source loaded_source(std::uint64_t seed, double load_s) {
  ident::PortableDraw levels(7);
  ident::PortableDraw draw(seed);
  Source source;
  source.name = fmt::format("loaded{}.csv", seed);
  source.record.step_s = 0.02;
  source.record.input.resize(4000);
  source.record.output.resize(4000);
  const double kept = load_s > 0.0 ? std::exp(-0.02 / load_s) : 0.0;
  double level = 0.0;
  double x = 0.0;
  double load = 0.0;
  for (Eigen::Index k = 0; k < 4000; ++k) {
    if (k % 40 == 0) level = 3.0 * levels.normal();
    source.record.input[k] = level;
    load = kept * load + 1.6 * std::sqrt(1.0 - kept * kept) * draw.normal();
    source.record.output[k] = x + load;
    x += (1.0 - std::exp(-0.02 / 0.2)) * (level - x);
  }
  return source;
}

TEST(Comparison, CertifiesNothingByAModelInWhoseRestAChangeMayHide) {
  const RunComparison loaded = compare_runs({loaded_source(1, 3.0), loaded_source(2, 3.0)});
  EXPECT_NEAR(loaded.runs[0].fit.model.estimation->score.r2_percent, 72.0, 8.0);
  EXPECT_FALSE(loaded.runs[1].change->changed);
  ASSERT_TRUE(loaded.runs[1].unfit);
  EXPECT_NE(loaded.runs[1].unfit->why.find("a change may hide in the rest"), std::string::npos)
      << loaded.runs[1].unfit->why;
  // Of plain noise the intervals know how much it hides.
  const RunComparison noisy = compare_runs({loaded_source(1, 0.0), loaded_source(2, 0.0)});
  EXPECT_NEAR(noisy.runs[0].fit.model.estimation->score.r2_percent, 72.0, 8.0);
  EXPECT_FALSE(noisy.runs[1].change->changed);
  EXPECT_FALSE(noisy.runs[1].unfit) << noisy.runs[1].unfit->why;
}

TEST(Comparison, ConvertsLengthsAndTakesRowsOfAnotherStep) {
  const Source one = source_of(seeded(1));
  Source other = source_of(seeded(1));
  other.record.output *= 25.4;
  other.record.output_channel.unit = "mm";
  Source inches = one;
  inches.record.output_channel.unit = "in";
  const RunComparison units = compare_runs({inches, other});
  EXPECT_FALSE(units.runs[1].change->changed);
  EXPECT_EQ(units.runs[1].fit.model.output_unit, "in");
  EXPECT_NEAR(units.runs[1].left_over.after, units.runs[1].left_over.before, 1e-6);
  // Every 20th row of the same record: the compared samples, every 0.04 s, are the same.
  Source coarse = one;
  coarse.record.step_s *= 20.0;
  coarse.record.input = one.record.input(Eigen::seq(0, Eigen::last, 20)).eval();
  coarse.record.output = one.record.output(Eigen::seq(0, Eigen::last, 20)).eval();
  const RunComparison steps = compare_runs({one, coarse});
  EXPECT_FALSE(steps.runs[1].has_other_input);
  ASSERT_EQ(steps.notes.size(), 1U);
  EXPECT_NE(steps.notes[0].find("both are compared every 0.04 s"), std::string::npos) << steps.notes[0];
  coarse.record.step_s = 0.0013;
  EXPECT_THROW(static_cast<void>(compare_runs({one, coarse})), DataError);
}

TEST(Comparison, TellsOtherInputsAndRefusesOtherUnits) {
  Source one = source_of(seeded(1));
  Source other = one;
  const RunComparison same = compare_runs({one, other});
  EXPECT_FALSE(same.runs.at(1).has_other_input);
  other.record.input *= 0.8;
  EXPECT_TRUE(compare_runs({one, other}).runs.at(1).has_other_input);
  other.record.output_channel.unit = "bar";
  EXPECT_THROW(static_cast<void>(compare_runs({one, other})), DataError);
}

/// A lag of `gain` behind a valve's dead band, driven by levels that the seed draws, and plain noise.
Source linear_source(std::uint64_t seed, double gain) {
  ident::PortableDraw draw(seed);
  Source source;
  source.name = "lag.csv";
  source.record.step_s = 0.02;
  source.record.input.resize(3000);
  Eigen::VectorXd flow(3000);
  double u = 0.0;
  for (Eigen::Index k = 0; k < 3000; ++k) {
    if (k % 25 == 0) u = 1.5 * draw.normal();
    source.record.input[k] = u;
    flow[k] = std::abs(u) > 0.3 ? u - std::copysign(0.3, u) : 0.0;
  }
  source.record.output = ident::simulate({{{gain, 0.0}}, {{0.03, 2.0}, {0.4, 1.0}, {1.0, 0.0}}, 0.0}, flow, 0.02);
  for (double& y : source.record.output) y += 0.02 * draw.normal();
  return source;
}

TEST(Comparison, HoldsTheParametersOfOtherInputsAgainstEachOtherWherePlainNoiseIsLeftOver) {
  const Source before = linear_source(1, 5.0);
  const RunComparison same = compare_runs({before, linear_source(2, 5.0)});
  EXPECT_FALSE(same.runs.at(1).has_other_input);
  EXPECT_FALSE(same.runs.at(1).change->changed);
  EXPECT_TRUE(same.notes.empty());
  const RunComparison grown = compare_runs({before, linear_source(3, 5.5)});
  EXPECT_FALSE(grown.runs.at(1).has_other_input);
  EXPECT_TRUE(grown.runs.at(1).change->changed);
  EXPECT_EQ(grown.runs.at(1).change->parameters.front().name, "K");
}

/// A heater: a lag with a dead time of whole seconds, rows every second, driven by levels of its own.
Source heater(std::uint64_t seed, double gain, double time_s, Eigen::Index delay_rows, Eigen::Index hold = 90) {
  ident::PortableDraw draw(seed);
  Source source;
  source.name = fmt::format("heater{}.csv", seed);
  source.record.step_s = 1.0;
  source.record.input.resize(1500);
  source.record.output.resize(1500);
  double level = 2.0;
  double x = gain * level;
  for (Eigen::Index k = 0; k < 1500; ++k) {
    if (k % hold == hold - 1) level = hold < 500 ? 1.0 + 7.0 * draw.uniform() : 6.0;
    source.record.input[k] = level;
    source.record.output[k] = 20.0 + x + 0.05 * draw.normal();
    const double u = source.record.input[std::max<Eigen::Index>(0, k - delay_rows)];
    x = x * std::exp(-1.0 / time_s) + (1.0 - std::exp(-1.0 / time_s)) * gain * u;
  }
  return source;
}

std::vector<std::string> changed_in(const RunComparison& comparison) {
  std::vector<std::string> names;
  for (const ident::ParameterChange& p : comparison.runs.at(1).change->parameters) {
    if (p.changed) names.push_back(p.name);
  }
  return names;
}

TEST(Comparison, NamesWhichOfGainTimeConstantAndDeadTimeChanged) {
  const Source before = heater(1, 3.2, 40.0, 6);
  using Names = std::vector<std::string>;
  const RunComparison delayed = compare_runs({before, heater(2, 3.2, 40.0, 9)});
  EXPECT_EQ(changed_in(delayed), Names{"delay_s"});
  EXPECT_TRUE(delayed.has_dead_time);
  EXPECT_TRUE(delayed.notes.empty()) << delayed.notes.front();
  EXPECT_FALSE(delayed.runs.at(1).has_other_input);
  EXPECT_EQ(changed_in(compare_runs({before, heater(3, 3.2, 48.0, 6)})), Names{"T"});
  EXPECT_EQ(changed_in(compare_runs({before, heater(4, 3.5, 40.0, 6)})), Names{"K/a0"});
  EXPECT_EQ(changed_in(compare_runs({before, heater(5, 3.2, 40.0, 6)})), Names{});
}

TEST(Comparison, SaysWhatTwoStepTestsTell) {
  const RunComparison steps = compare_runs({heater(1, 3.2, 40.0, 6, 700), heater(2, 3.6, 40.0, 6, 700)});
  EXPECT_EQ(changed_in(steps), std::vector<std::string>{"K/a0"});
  ASSERT_FALSE(steps.notes.empty());
  EXPECT_NE(steps.notes.back().find("Each record has one step"), std::string::npos) << steps.notes.back();
  EXPECT_TRUE(steps.runs.at(1).change->undetermined.empty());
}

}  // namespace
}  // namespace eha::identify
