// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/tune.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "daemon/tune/controller_answer.hpp"
#include "daemon/tune/controller_page.hpp"
#include "daemon/tune/expected_trip.hpp"
#include "daemon/tune/kind_table.hpp"
#include "daemon/tune/promised_plant.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/sim/cylinder.hpp"

namespace eha::tune {
namespace {

ident::Model rod(const hal::SimOptions& rig) {
  const TwinGains gains = gains_of(rig);
  ident::Model model;
  model.name = "rod";
  model.input_map = ident::ValveMap{-rig.valve_null_offset_V, rig.valve_dead_band_V, gains.negative / gains.positive};
  model.transfer_function = {{{gains.positive, 0}}, {{0.0065, 2}, {1, 1}}, 0.0};
  model.initial_output = 2.95;
  return model;
}

TuneTask task_for(const hal::SimOptions& rig) {
  TuneTask task;
  task.axis.lowest = 0.15;
  task.axis.highest = 5.75;
  task.axis.velocity_limit = 8.0;
  task.axis.noise = rig.sensor_noise_V * rig.scale_in_per_V;
  task.axis.lsb = rig.scale_in_per_V * 20.0 / 65535.0;
  task.axis.draws = 40;
  task.kind = ident::FeedbackKind::p;
  task.twin = rig;
  task.twins = 4;
  task.hold_s = 8.0;
  return task;
}

TEST(MotionFigure, SaysThatItsErrorsAreMeans) {
  TrialTrace trace{{0.0, 0.001}, {1.0, 1.0}, {1.0, 1.1}, {0.0, 0.1}};
  EXPECT_EQ(motion_figure(trace, "trial").panels.at(1).series.front().label, "");
  trace.sweep_s = {0.0005, 0.002};
  EXPECT_TRUE(std::isnan(motion_figure(trace, "trial").panels.at(1).series.front().y.at(1)));
  EXPECT_FALSE(std::isnan(motion_figure(trace, "trial").panels.at(1).series.front().y.at(0)));
  trace.mean_s = 0.05;
  EXPECT_EQ(motion_figure(trace, "trial").panels.at(1).series.front().label, "means over 50 ms");
}

TEST(ControllerPage, BeginsWithWhatTheControllerAchievesAndWhatToDoNext) {
  ControllerSubject subject;
  config::ControllerConfig& c = subject.controller;
  c.name = "axis";
  c.settings.reference = {.lowest = 0.5, .highest = 5.5, .velocity = 0.2, .acceleration = 1.0, .jerk = 10.0};
  c.promise.twins = 50;
  c.promise.following_worst_in = {0.001, 0.0005, 0.0026};
  c.promise.overshoot_in = {0.0, 0.0, 0.0012};
  c.promise.phase_margin_deg = {80.0, 69.0, 80.0};
  c.promise.remarks = "The margin limits the gain.\nThe promise is of a simulated rig.";
  std::string html = answer_box(subject);
  EXPECT_NE(
      html.find(": error within 0.001 in while it moves, 0 in at rest, in the median of 50 simulated trials; promised"),
      std::string::npos)
      << html;
  EXPECT_EQ(html.rfind("<section class=\"verdict some\"><h2>P controller", 0), 0U) << html;
  for (const char* told :
       {"within 0.0026 in of the reference", "overshoots by at most 0.0012 in", "phase 80 degrees and at least 69",
        "<li>The margin limits the gain.</li>", "Next: <code>eha track axis.toml</code>",
        "<code>eha export axis.toml --format st -o axis_control.st</code>"}) {
    EXPECT_NE(html.find(told), std::string::npos) << told << " in " << html;
  }
  subject.measured.emplace().figures = {
      {.name = "following error, worst", .value = 0.1, .unit = "in", .kept = "no", .limit = 0.0026}};
  subject.measured->changes = {"half dead band 0.22 V instead of 0.15 V"};
  subject.measured->advice = "Valve or load differ: `eha characterise`, then `eha tune`.";
  html = answer_box(subject);
  EXPECT_EQ(html.rfind("<section class=\"verdict none\">", 0), 0U) << html;
  EXPECT_NE(html.find("The rig did not keep: following error, worst (0.1 in, promised at most 0.0026);"),
            std::string::npos)
      << html;
  EXPECT_NE(html.find("the promise is not kept</h2>"), std::string::npos) << html;
  EXPECT_GT(html.find("trials on 50 drawn rigs"), html.find("<details>")) << "what was promised is no answer";
  EXPECT_LT(html.find("half dead band 0.22 V instead of 0.15 V"), html.find("<code>eha characterise</code>")) << html;
  subject.measured->figures.front().kept = "yes";
  html = answer_box(subject);
  EXPECT_NE(html.find("<p>Next: what is said above of the moving rod"), std::string::npos) << html;
  EXPECT_EQ(html.find("eha export"), std::string::npos) << html;
  subject.measured->advice.clear();
  subject.measured->leaks = true;
  html = answer_box(subject);
  EXPECT_NE(html.find(": the rig leaks; greatest measured error"), std::string::npos) << html;
  EXPECT_NE(html.find("<p>Next: repair the leak first"), std::string::npos) << html;
  EXPECT_EQ(html.find("eha export"), std::string::npos) << html;
  subject.measured->leaks = false;
  html = answer_box(subject);
  EXPECT_NE(html.find("<p>Next: <code>eha export axis.toml"), std::string::npos) << html;
  EXPECT_NE(html.find("greatest measured error 0.1 in, promise kept</h2>"), std::string::npos) << html;
  EXPECT_NE(html.find("half dead band 0.22 V instead of 0.15 V"), std::string::npos) << "worth knowing all the same";
  subject.measured->figures.push_back({.name = "settling", .value = 0.0, .unit = "s", .kept = "hidden by noise"});
  html = answer_box(subject);
  EXPECT_EQ(html.find("promise kept"), std::string::npos) << html;
  EXPECT_NE(html.find(": greatest measured error 0.1 in, 1 of 2 figures kept, 1 hidden by noise</h2>"),
            std::string::npos)
      << html;
}

TEST(ControllerPage, BeginsWithTheTripOfATrialThatWillNotPass) {
  ControllerSubject subject;
  subject.controller.name = "axis";
  subject.controller.promise.remarks = "The margin limits the gain.";
  EXPECT_EQ(answer_box(subject).find("will trip"), std::string::npos);
  subject.controller.promise.remarks =
      sentence_of({.breach = {acquisition::Fault::no_motion, 0.0, 0.003}, .at_s = 4.2, .is_of_leak = true}, {}) + "\n" +
      subject.controller.promise.remarks;
  const std::string html = answer_box(subject);
  EXPECT_NE(html.find("its trial will trip on this rig</h2>"), std::string::npos) << html;
  EXPECT_LT(html.find("Repair the leak"), html.find("<details>")) << html;
}

TEST(ControllerPage, SaysOfATrialsCurveWhichPartHasWhichFigure) {
  ControllerSubject subject;
  subject.controller.name = "axis";
  MeasuredTrial& trial = subject.measured.emplace();
  trial.run = "run";
  trial.figures = {{.name = "following error, worst", .value = 0.00106, .unit = "in", .kept = "yes"},
                   {.name = "overshoot of a step", .value = 1e-5, .unit = "in", .kept = "yes"}};
  trial.trace = {.time_s = {0.0, 1.0, 2.0, 3.0},
                 .reference_in = {1.0, 1.0, 1.0, 1.0},
                 .rod_in = {1.0, 1.00106, 1.5, 0.9986},
                 .command_V = {0.0, 0.0, 0.0, 0.0},
                 .sweep_s = std::pair(1.5, 2.5),
                 .mean_s = 0.05};
  const std::string html = controller_page(subject).html;
  EXPECT_NE(html.find("The greatest error of the curve is 0.0014 in at 3 s."), std::string::npos)
      << "of the sine, of which the table has the RMS alone";
  EXPECT_NE(html.find("greatest error in the trapezoids 0.00106 in"), std::string::npos) << html;
  trial.trace.time_s[3] = 2.51;  // its mean has rows of the sweep
  EXPECT_NE(controller_page(subject).html.find("The greatest error of the curve is 0.00106 in at 1 s."),
            std::string::npos);
  const plot::Series error = motion_figure(trial.trace, "trial").panels.at(1).series.front();
  EXPECT_TRUE(std::isnan(error.y.back())) << "not drawn either";
  EXPECT_NE(html.find("may reach further than the worst following error of the table"), std::string::npos);
  trial.figures.pop_back();  // a user's reference, of which the table has the following error alone
  EXPECT_NE(controller_page(subject).html.find("The error is as in the table."), std::string::npos);
}

TEST(TwinDraws, HaveTheGainsOfTheSimulatedCylinder) {
  hal::SimOptions rig;
  const TwinGains gains = gains_of(rig);
  for (const double beyond_V : {0.6, -0.6}) {
    hal::Cylinder cylinder(rig);
    const double command_V = -rig.valve_null_offset_V + std::copysign(rig.valve_dead_band_V, beyond_V) + beyond_V;
    cylinder.advance(command_V, hal::Ports::open, 1.0);
    const double before_m = cylinder.state().displacement_m;
    cylinder.advance(command_V, hal::Ports::open, 1.0);
    const double gain = (cylinder.state().displacement_m - before_m) / 0.0254 / beyond_V;
    EXPECT_NEAR(gain, beyond_V > 0.0 ? gains.positive : gains.negative, 0.05 * gain) << beyond_V;
  }
}

TEST(TwinDraws, OfAnEstimatedTwinHaveThePlantsValve) {
  hal::SimOptions rig;
  rig.valve_rated_flow_L_per_min = 1.7;
  rig.valve_dead_band_V = 0.3;
  rig.rod_mm = 24.0;
  const TuneTask task = task_for(rig);
  const ident::AxisPlant plant = ident::axis_plant(rod(rig), task.axis);
  const hal::SimOptions twin = estimated_twin(plant, hal::SimOptions{});
  EXPECT_NEAR(gains_of(twin).positive, gains_of(rig).positive, 1e-3 * gains_of(rig).positive);
  EXPECT_NEAR(gains_of(twin).negative, gains_of(rig).negative, 1e-3 * gains_of(rig).negative);
  EXPECT_EQ(twin.valve_dead_band_V, 0.3);
  EXPECT_TRUE(hal::check(twin).empty());
  for (hal::SimOptions drawn : drawn_twins(twin, spread_about_estimated(plant.valve), 0.15, 5.75, 20, 1)) {
    drawn.sub_step_us = 1.0;  // trials take steps of their own
    EXPECT_TRUE(hal::check(drawn).empty());
    EXPECT_GT(drawn.initial_displacement_in, 0.15);
    EXPECT_LT(drawn.initial_displacement_in, 5.75);
  }
}

TEST(PromisedPlant, NamesAGainAUnitAndALagThatAreNotThoseOfTheTrialsRig) {
  TuneInputs inputs;
  inputs.model_gain_in_per_V_s = 0.13;
  EXPECT_FALSE(returns_in_s(inputs)) << "a model without a usable band";
  inputs.lowest_Hz = 0.1;
  EXPECT_EQ(why_another_plant(inputs), "") << "a rig whose gain is not known";
  inputs.rig_gain_in_per_V_s = 0.15;
  inputs.rig_gain_of = "the simulated rig";
  EXPECT_EQ(why_another_plant(inputs), "");
  inputs.model_gain_in_per_V_s = 2.1 * 0.15;
  EXPECT_NE(why_another_plant(inputs).find("2.1 times that"), std::string::npos) << why_another_plant(inputs);
  inputs.model_gain_in_per_V_s = 25.0 * 0.15;
  EXPECT_NE(why_another_plant(inputs).find("mm taken for inches"), std::string::npos) << why_another_plant(inputs);
  inputs.model_gain_in_per_V_s = 0.15;
  inputs.plant.inverse.position = 0.2;  // slower than the band
  EXPECT_EQ(why_another_plant(inputs), "");
  inputs.plant.inverse.position = 2.0;
  EXPECT_NE(why_another_plant(inputs).find("does not integrate"), std::string::npos) << why_another_plant(inputs);
  EXPECT_DOUBLE_EQ(returns_in_s(inputs).value_or(0.0), 0.5);
}

TEST(TuneInputs, TakeTheValveOfFollowingWhereTheErrorOfTheModelsMapMovedItsOwn) {
  const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim-leaky.toml");
  ident::Model model = rod(std::get<hal::SimOptions>(rig.backend));
  model.input_unit = "V";
  model.output_unit = "in";
  model.input_map->null = -0.403;
  model.input_map->dead_band = 0.223;
  EXPECT_NEAR(tune_inputs(model, rig, {}).plant.valve.null, -0.403, 1e-9) << "nothing speaks against the map";
  model.validation.emplace().map_error = 0.136;
  TuneInputs inputs = tune_inputs(model, rig, {});
  EXPECT_NEAR(inputs.plant.valve.null, -0.2, 1e-9);
  EXPECT_NEAR(inputs.plant.valve.dead_band, 0.15, 1e-9);
  EXPECT_NEAR(inputs.task.axis.command_max, -0.2 + config::closed_loop_most_V(rig.limits), 1e-9);
  inputs.task.kind = ident::FeedbackKind::p;
  inputs.task.twins = 2;
  inputs.task.hold_s = 2.0;
  const Tuned tuned = tune(inputs.plant, inputs.task);
  EXPECT_TRUE(std::any_of(tuned.remarks.begin(), tuned.remarks.end(), [](const std::string& remark) {
    return remark.rfind("Null -0.200 V and half dead band 0.150 V are those of [following]", 0) == 0;
  })) << tuned.remarks.front();
  inputs.task.valve_of = ValveOrigin::sheet;
  const Tuned by_sheet = tune(inputs.plant, inputs.task);
  EXPECT_TRUE(std::any_of(by_sheet.remarks.begin(), by_sheet.remarks.end(), [](const std::string& remark) {
    return remark.find("the model -0.403 and 0.223 V, 0.203 and 0.073 V away;") != std::string::npos;
  })) << by_sheet.remarks.front();
  model.input_map->null = -1.2;
  EXPECT_NEAR(tune_inputs(model, rig, {}).plant.valve.null, -1.2, 1e-9) << "the map's error does not explain that";
}

TEST(SwingCounter, CountsSwingsOfTheLastSecond) {
  ident::SwingCounter swings(-0.2, 0.3, 0.01);
  int most = 0;
  for (int i = 0; i < 500; ++i) most = std::max(most, swings.step(-0.2 + 0.4 * ((i / 10) % 2 == 0 ? 1.0 : -1.0)));
  EXPECT_NEAR(most, 10, 1);
  for (int i = 0; i < 200; ++i) most = swings.step(-0.2 + 0.2 * (i % 2 == 0 ? 1.0 : -1.0));
  EXPECT_EQ(most, 0);
}

TEST(Tune, PromisesAFractionOfTheErrorOfAPureGain) {
  const hal::SimOptions rig;
  const TuneTask task = task_for(rig);
  const ident::AxisPlant plant = ident::axis_plant(rod(rig), task.axis);
  const Tuned tuned = tune(plant, task);
  EXPECT_LT(tuned.promise.following_rms_in.upper, 0.0015);
  EXPECT_LT(tuned.promise.standing_in.upper, most_standing_in(task.axis));
  EXPECT_LE(tuned.promise.ms.upper, 1.42);
  EXPECT_GT(tuned.fault.following_error_in, tuned.promise.following_worst_in.upper);
  EXPECT_FALSE(tuned.remarks.empty());
  EXPECT_EQ(tuned.trials.size(), 4U);
  // The margin is named only where it binds.
  const bool binds =
      tuned.share >= 1.0 && !tuned.design.noise_binds && tuned.design.margins.peak95 > 0.97 * task.axis.sensitivity;
  EXPECT_EQ(std::any_of(tuned.remarks.begin(), tuned.remarks.end(),
                        [](const std::string& remark) { return remark.starts_with("The margin limits the gain"); }),
            binds);
  EXPECT_EQ(std::any_of(tuned.remarks.begin(), tuned.remarks.end(),
                        [](const std::string& remark) { return remark.starts_with("The trials limit the gain"); }),
            tuned.share < 1.0);
  EXPECT_GT(tuned.trace.time_s.size(), 1000U);

  // A gain alone: no inverse of the dead band, no feed-forward, the best of several.
  double best = 1.0;
  for (const double kp : {5.0, 10.0, 20.0, 40.0, 80.0, 120.0}) {
    ident::AxisSettings pure = tuned.design.settings;
    pure.feedback = {.kp = kp};
    pure.inverse.dead_band = 0.0;
    pure.inverse.gain_negative = pure.inverse.gain_positive;
    pure.inverse.null = 0.0;
    pure.feed_forward = {.velocity_share = 0.0};
    pure.most_speed = 100.0;
    ident::TrialPlan plan = ident::trial_plan(tuned.design.settings);
    plan.hold_s = 2.0;
    best = std::min(best, axis_trial(rig, ident::coefficients(pure), plan).following_rms_in);
  }
  EXPECT_LT(tuned.promise.following_rms_in.value, 0.5 * best);
}

TEST(Tune, IsTheSameAgain) {
  const hal::SimOptions rig;
  const TuneTask task = task_for(rig);
  const ident::AxisPlant plant = ident::axis_plant(rod(rig), task.axis);
  const Tuned a = tune(plant, task);
  const Tuned b = tune(plant, task);
  EXPECT_EQ(a.design.settings, b.design.settings);
  EXPECT_EQ(a.promise.following_rms_in.upper, b.promise.following_rms_in.upper);
}

TEST(Tune, ComparesKindsUnderOneLoadAndSaysLengthsInTheUnitThatIsAsked) {
  const hal::SimOptions rig;
  TuneTask task = task_for(rig);
  task.kind.reset();
  task.unit = DisplayUnit("mm");
  const Tuned tuned = tune(ident::axis_plant(rod(rig), task.axis), task);
  const auto row = [&](ident::FeedbackKind kind) {
    return std::find_if(tuned.kinds.begin(), tuned.kinds.end(), [&](const ComparedKind& k) { return k.kind == kind; });
  };
  const auto p = row(ident::FeedbackKind::p);
  const auto pid = row(ident::FeedbackKind::pid);
  const auto fopid = row(ident::FeedbackKind::fopid);
  ASSERT_NE(p, tuned.kinds.end());
  ASSERT_NE(pid, tuned.kinds.end());
  ASSERT_NE(fopid, tuned.kinds.end());
  EXPECT_GT(p->lasting_error_s, 0.0);
  EXPECT_FALSE(p->load_error_of_pid) << "without an integral the error stays";
  EXPECT_EQ(pid->lasting_error_s, 0.0);
  EXPECT_EQ(pid->load_error_of_pid, 1.0);
  EXPECT_LE(*fopid->load_error_of_pid, 1.0) << "a PID is a FOPID";
  EXPECT_FALSE(fopid->following_rms_in) << "it was not tried";
  // A row for people: P follows with so many millimetres.
  const auto rows = kind_rows(tuned.kinds, task.unit);
  ASSERT_EQ(rows.size(), tuned.kinds.size());
  EXPECT_NEAR(std::stod(rows.front()[1]), 25.4 * *tuned.kinds.front().following_rms_in,
              0.01 * 25.4 * *tuned.kinds.front().following_rms_in);
  std::string remarks;
  for (const std::string& sentence : tuned.remarks) remarks += sentence + "\n";
  EXPECT_NE(remarks.find(" mm/s"), std::string::npos) << remarks;
  EXPECT_EQ(remarks.find(" in/s"), std::string::npos) << remarks;
  EXPECT_EQ(remarks.find(" in RMS"), std::string::npos) << remarks;
  // A controller without an integral is offered with what a load does to it.
  if (tuned.design.settings.feedback.ki > 0.0) GTEST_FAIL() << "of this rig P is the simplest that does";
  EXPECT_NE(tuned.remarks.front().find("Without an integral a lasting load keeps the rod away: one that would move it "
                                       "at 1 mm/s by "),
            std::string::npos)
      << remarks;
  EXPECT_NE(tuned.remarks.front().find("nothing of it stays, and the rod follows within "), std::string::npos)
      << remarks;
}

TEST(Tune, TakesAModelWithAResonanceWhoseResponseIsTinyAtTheTick) {
  const hal::SimOptions rig;
  TuneTask task = task_for(rig);
  ident::Model cylinder = rod(rig);
  cylinder.transfer_function.denominator = {{1.1844e-4, 3}, {6.1203e-3, 2}, {1, 1}};
  for (const ident::FeedbackKind kind : {ident::FeedbackKind::p, ident::FeedbackKind::pid}) {
    task.kind = kind;
    const Tuned tuned = tune(ident::axis_plant(cylinder, task.axis), task);
    EXPECT_GT(tuned.design.settings.feedback.kp, 0.0);
    EXPECT_LT(tuned.design.settings.feedback.kp, 100.0) << "the resonance at 14.6 Hz limits it";
    EXPECT_LE(tuned.design.margins.peak95, task.axis.sensitivity);
  }
}

TEST(Tune, OffersNothingThatHunts) {
  // The true valve has three times the dead band that the model knows, and much friction: the rod hunts about it.
  hal::SimOptions rig;
  TuneTask task = task_for(rig);
  const ident::AxisPlant plant = ident::axis_plant(rod(rig), task.axis);
  task.twin.valve_dead_band_V = 0.02;  // the inverse overcompensates
  task.twin.valve_rated_flow_L_per_min *= 6.0;
  task.kind = ident::FeedbackKind::pi;
  try {
    const Tuned tuned = tune(plant, task);
    EXPECT_LE(tuned.promise.standing_in.value, most_standing_in(task.axis));
    for (const ident::TrialFigures& trial : tuned.trials) EXPECT_LE(trial.standing_in, most_standing_in(task.axis));
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("hunts"), std::string::npos);
  }
}

}  // namespace
}  // namespace eha::tune
