// SPDX-License-Identifier: GPL-3.0-or-later
// A controller that was tuned for a simulated rig, played on it and on rigs that have changed since, through the loop.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "config/measured_check.hpp"
#include "config/needs_following.hpp"
#include "config/prepared_experiment.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/play/play.hpp"
#include "daemon/record/number_table.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/report.hpp"
#include "daemon/track/track_result.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/valve/supply.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::track {
namespace {

using acquisition::Fault;
using acquisition::Outcome;

class Track : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml");
    const auto& sim = std::get<hal::SimOptions>(rig.backend);
    const tune::TwinGains gains = tune::gains_of(sim);
    ident::Model model;
    model.name = "rod";
    model.input_unit = "V";
    model.output_unit = "in";
    model.input_map = ident::ValveMap{-sim.valve_null_offset_V, sim.valve_dead_band_V, gains.negative / gains.positive};
    model.transfer_function = {{{gains.positive, 0}}, {{0.0065, 2}, {1, 1}}, 0.0};
    model.initial_output = 2.95;
    tune::TuneInputs inputs = tune::tune_inputs(model, rig, {.kind = ident::FeedbackKind::p});
    inputs.task.twins = 12;
    const tune::Tuned tuned = tune::tune(inputs.plant, inputs.task);
    config::ControllerProvenance from{.model = "model.json",
                                      .model_sha256 = std::string(64, '0'),
                                      .rig = rig.name,
                                      .rig_file = "rig.toml",
                                      .rig_sha256 = std::string(64, '0'),
                                      .twin = "itself",
                                      .run = "unknown",
                                      .made_by = "test"};
    text_ = config::controller_text(tune::controller_of(tuned, inputs, std::move(from), "axis"));
  }

  void SetUp() override { rig_ = config::load_rig(EHA_SOURCE_DIR "/config/rigs/sim.toml"); }
  hal::SimOptions& sim() { return std::get<hal::SimOptions>(rig_.backend); }

  [[nodiscard]] config::PreparedExperiment prepared(const std::string& controller, const std::string& more = "") const {
    return config::parse_prepared_experiment(
        "schema = 1\nname = \"track\"\n\n[track]\n" + more + "controller = '''\n" + controller + "'''\n", "track.toml",
        rig_);
  }

  play::FinishedRun played(const std::string& controller) {
    const config::PreparedExperiment experiment = prepared(controller, "hold_s = 6.0\ntrapezoids = 1\n");
    const std::unique_ptr<hal::Rig> rig = hal::open_rig(sim(), rig_.limits.safe_V);
    acquisition::StateMachine machine;
    EXPECT_TRUE(machine.reset() && machine.arm());
    acquisition::StopRequest stop;
    const play::PlayRequest request{
        .rig = rig_,
        .experiment = experiment.config,
        .table_V = {experiment.table_V.data(), static_cast<std::size_t>(experiment.table_V.size())},
        .folder = record::create_run_folder(folder_.path() / "runs", "track"),
        .time_base = acquisition::TimeBase::virtual_time};
    return play::play(*rig, machine, request, stop);
  }

  [[nodiscard]] std::string refusal(const std::string& controller) const {
    try {
      static_cast<void>(prepared(controller));
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "accepted";
  }

  /// The controller with another value of a key.
  static std::string with(const std::string& key, const std::string& value) {
    std::string text = text_;
    const std::size_t at = text.find("\n" + key + " = ");
    EXPECT_NE(at, std::string::npos) << key;
    const std::size_t begin = at + key.size() + 4;
    return text.replace(begin, text.find('\n', begin) - begin, value);
  }
  static double number(const std::string& key) {
    const std::size_t at = text_.find("\n" + key + " = ");
    return std::stod(text_.substr(at + key.size() + 4));
  }

  static std::string text_;
  config::RigConfig rig_;
  test::TemporaryFolder folder_;
};

std::string Track::text_;

TEST_F(Track, KeepsItsPromiseOnItsRig) {
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::completed) << acquisition::describe(run.report);
  const TrackResult result = track_result(record::OpenRun(run.folder));
  EXPECT_TRUE(result.is_kept()) << track_text(result, DisplayUnit("in"));
  EXPECT_TRUE(changes_of(result, DisplayUnit("in")).empty()) << track_text(result, DisplayUnit("in"));
  EXPECT_NEAR(result.noise_in, sim().sensor_noise_V * sim().scale_in_per_V, 0.1 * result.noise_in);
  EXPECT_LT(result.rows.rod_in.size(), 60'000U);
}

TEST_F(Track, MeasuresTheSettlingFinerThanItIsPromised) {
  const TrackResult result = track_result(record::OpenRun(played(text_).folder));
  const auto settling = std::find_if(result.figures.begin(), result.figures.end(),
                                     [](const KeptFigure& f) { return f.name.starts_with("settling"); });
  ASSERT_NE(settling, result.figures.end());
  EXPECT_LE(settling->noise, settling->limit()) << "else a kept promise would say nothing";
  EXPECT_EQ(kept_text(*settling), "yes") << settling->measured << " of " << settling->limit();
}

TEST(KeptFigureTest, IsDecidedOnlyBeyondWhatTheNoiseMayDo) {
  KeptFigure figure;
  figure.noise = 0.05;
  figure.promised.upper = 0.01;
  EXPECT_EQ(kept_text(figure), "yes") << "noise that only adds";
  figure.is_two_sided = true;
  EXPECT_EQ(kept_text(figure), "hidden by noise");
  EXPECT_TRUE(figure.is_kept());
  figure.measured = 0.2;
  EXPECT_EQ(kept_text(figure), "no");
  figure.promised.upper = 0.3;
  EXPECT_EQ(kept_text(figure), "yes");
}

TEST_F(Track, NamesADeadBandThatHasGrown) {
  sim().valve_dead_band_V += 0.1;
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::completed) << acquisition::describe(run.report);
  const TrackResult result = track_result(record::OpenRun(run.folder));
  EXPECT_FALSE(result.is_kept());
  const std::vector<std::string> changes = changes_of(result, DisplayUnit("mm"));
  ASSERT_EQ(changes.size(), 1U) << track_text(result, DisplayUnit("in"));
  EXPECT_TRUE(changes.front().starts_with("half dead band")) << changes.front();
  EXPECT_NEAR(result.valve.dead_band_V, sim().valve_dead_band_V, 0.01);
}

TEST_F(Track, NamesGainsThatHaveFallen) {
  sim().valve_rated_flow_L_per_min *= 0.8;
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::completed) << acquisition::describe(run.report);
  const TrackResult result = track_result(record::OpenRun(run.folder));
  EXPECT_FALSE(result.is_kept());
  const std::vector<std::string> changes = changes_of(result, DisplayUnit("mm"));
  ASSERT_EQ(changes.size(), 2U) << track_text(result, DisplayUnit("in"));
  for (const std::string& change : changes) {
    EXPECT_TRUE(change.starts_with("gain")) << change;
    EXPECT_NE(change.find("mm/(V s)"), std::string::npos) << "in the unit that is asked for: " << change;
  }
  const std::string advice = advice_of(result, DisplayUnit("mm"));
  EXPECT_NE(advice.find(ident::kSupplyFirst), std::string::npos) << advice;
}

TEST_F(Track, NamesASlowerValveWhereTheNewestSheetAgreesInAllElse) {
  sim().valve_natural_frequency_Hz = 3.0;
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::faulted);
  EXPECT_FALSE(ended_trial(record::OpenRun(run.folder), {}).is_cause_known()) << "without a sheet";
  const config::ValveEstimate valve = config::valve_estimate(*rig_.limits.following);
  const auto write_sheet = [&](double lag_s, double null_V) {
    std::ofstream(run.folder / record::kSheetFile)
        << nlohmann::json{{"null_V", {{"value", null_V}}},
                          {"dead_band_V", {{"value", valve.dead_band_V}}},
                          {"gain_positive_in_per_V_s", {{"value", valve.gain_positive_in_per_V_s}}},
                          {"gain_negative_in_per_V_s", {{"value", valve.gain_negative_in_per_V_s}}},
                          {"lag_s", lag_s}};
  };
  write_sheet(0.084, valve.null_V);
  const EndedTrial slower = ended_trial(record::OpenRun(run.folder), {});
  EXPECT_NE(slower.cause.find("slower than the controller's model"), std::string::npos) << slower.cause;
  write_sheet(0.0065, valve.null_V);
  EXPECT_EQ(ended_trial(record::OpenRun(run.folder), {}).cause, "") << "as fast as the model";
  write_sheet(0.084, valve.null_V + 0.4);
  EXPECT_EQ(ended_trial(record::OpenRun(run.folder), {}).cause, "") << "[following] comes first";
}

TEST_F(Track, NamesASensorWhoseReadingJumps) {
  sim().sensor_noise_V = 0.02;
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::faulted);
  const EndedTrial trial = ended_trial(record::OpenRun(run.folder), {});
  EXPECT_TRUE(trial.is_of_sensor) << acquisition::describe(run.report);
  EXPECT_NE(trial.cause.find("reading jumps"), std::string::npos) << trial.cause;
}

TEST(SeenValve, LeavesOutTheLesserOfTwoChangesThatLittleMotionGives) {
  const ident::InverseMap map{.null = -0.2, .dead_band = 0.151, .gain_positive = 0.148, .gain_negative = 0.131};
  const SeenValve seen{-0.139, 0.302, 0.148, 0.131, 0.02, 0.01};
  EXPECT_EQ(changes_of(seen, map, {}), std::vector<std::string>{"half dead band 0.302 V instead of 0.151 V"});
  EXPECT_EQ(changes_of({-0.6, 0.302, 0.148, 0.131, 0.02, 0.01}, map, {}).size(), 2U) << "both are clear";
  EXPECT_TRUE(changes_of({-0.169, 0.131, 0.148, 0.131, 0.01, 0.01}, map, {}).empty()) << "a few moves tell little";
  EXPECT_EQ(changes_of({-0.2, 0.151, 0.12, 0.131, 0.01, 0.01, 0.01}, map, {}).size(), 1U);
  EXPECT_TRUE(changes_of({-0.2, 0.151, 0.12, 0.131, 0.01, 0.01, 0.1}, map, {}).empty());
}

TEST_F(Track, StopsALoopThatOscillates) {
  const play::FinishedRun run = played(with("kp_per_s", fmt::format("{}", 10.0 * number("kp_per_s"))));
  EXPECT_EQ(run.report.outcome, Outcome::faulted);
  EXPECT_TRUE(run.report.fault.fault == Fault::oscillation || run.report.fault.fault == Fault::following_error)
      << acquisition::describe(run.report);
}

TEST_F(Track, StopsALoopWhoseRodDoesNotFollow) {
  sim().valve_rated_flow_L_per_min *= 0.02;
  const play::FinishedRun run = played(text_);
  EXPECT_EQ(run.report.outcome, Outcome::faulted);
  EXPECT_EQ(run.report.fault.fault, Fault::following_error) << acquisition::describe(run.report);
  std::ofstream(run.folder / record::kSheetFile)
      << R"({"creep_in_per_s": {"value": 0.0171}, "gain_positive_in_per_V_s": {"value": 0.122},
             "gain_negative_in_per_V_s": {"value": 0.122}})";
  write_ended_track(record::OpenRun(run.folder));
  const record::NumberTable rows = record::read_number_table(run.folder / kTrackRows);
  const TrackResult ended = played_track(record::OpenRun(run.folder));
  ASSERT_EQ(rows.rows(), ended.rows.rod_in.size());
  // The error that ended it is seen in the rows.
  const std::vector<double>& error = *rows.find("error_in");
  const auto [least, greatest] = std::minmax_element(error.begin(), error.end());
  EXPECT_GT(std::max(-*least, *greatest), number("following_error_in"));
  EXPECT_NEAR(error.back(), rows.find("displacement_in")->back() - rows.find("reference_in")->back(), 1e-5);
  const report::Subject subject = report::load_run(run.folder);
  ASSERT_TRUE(subject.trip_s() && ended.trip_s);
  EXPECT_NEAR(*subject.trip_s(), *ended.trip_s, 1e-9) << "one clock";
  EXPECT_LT(rows.find("time_s")->back(), *ended.trip_s);
  EXPECT_GT(rows.find("time_s")->back(), *ended.trip_s - 0.002);
  ASSERT_EQ(subject.track.models.size(), 1U);
  EXPECT_EQ(subject.track.models[0].model, "reference");
  ASSERT_TRUE(subject.leak);
  EXPECT_NEAR(subject.leak->as_V, 0.14, 1e-3);
  EXPECT_NE(report::page_of(subject).html.find("Rod, reference and command until the trial ended"), std::string::npos);
}

TEST_F(Track, NamesTheLeakOfTheSheetAndDoesNotLeadRoundInACircle) {
  sim().leakage_cm3_per_s_per_bar = 0.03;
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::completed) << acquisition::describe(run.report);
  TrackResult result = track_result(record::OpenRun(run.folder));
  ASSERT_FALSE(result.is_kept() && changes_of(result, DisplayUnit("in")).empty()) << "a leak that nothing shows";
  EXPECT_FALSE(result.leak) << "no sheet is there";
  EXPECT_NE(advice_of(result, DisplayUnit("in")).find("`eha characterise`"), std::string::npos);
  std::ofstream(run.folder / record::kSheetFile)
      << R"({"creep_in_per_s": {"value": 0.006}, "gain_positive_in_per_V_s": {"value": 0.122},
             "gain_negative_in_per_V_s": {"value": 0.122}})";
  result = track_result(record::OpenRun(run.folder));
  ASSERT_TRUE(result.leak);
  EXPECT_FALSE(goes_to_plc(result, DisplayUnit("in")));
  const std::string text = track_text(result, DisplayUnit("in"));
  EXPECT_NE(text.find("repair the leak first"), std::string::npos) << text;
  EXPECT_EQ(text.find(": `eha characterise`"), std::string::npos) << text;
  EXPECT_EQ(text.find("with its sheet"), std::string::npos) << text;
}

TEST_F(Track, IsRefusedForAnotherRigTickOrTravel) {
  EXPECT_EQ(refusal(text_), "accepted");
  EXPECT_NE(refusal(with("rig", "\"other\"")).find("a controller for simulated rig"), std::string::npos);
  EXPECT_NE(refusal(with("tick_s", "0.002")).find("tick of 0.001 s"), std::string::npos)
      << refusal(with("tick_s", "0.002"));
  EXPECT_NE(refusal(with("following_error_in", "0.6")).find("a twentieth of the travel"), std::string::npos);
  EXPECT_NE(refusal("schema = 7\n").find("the text of a controller file"), std::string::npos);
  EXPECT_EQ(refusal("schema = 7\n").find("duration_s"), std::string::npos) << "it follows from the controller";
  rig_.limits.travel_max_in = 3.0;
  EXPECT_NE(refusal(text_).find("travel within"), std::string::npos);
  rig_.limits.slew_V_per_s = 1.0;
  EXPECT_NE(refusal(text_).find("slew of at most 1 V/s"), std::string::npos);
}

TEST_F(Track, IsRefusedOnAMachineWithoutFollowing) {
  rig_.limits.following.reset();
  EXPECT_EQ(refusal(text_), "accepted") << "a simulated rig";
  rig_.backend = hal::ComediOptions{};
  EXPECT_NE(refusal(text_).find(config::kNeedsFollowing), std::string::npos) << refusal(text_);
}

TEST_F(Track, IsRefusedForAnotherValveThanThatOfFollowing) {
  for (const auto& [key, value] : {std::pair{"null_V", "-0.32"},
                                   {"dead_band_V", "0.27"},
                                   {"gain_positive_in_per_V_s", "0.3"},
                                   {"gain_negative_in_per_V_s", "0.08"}}) {
    EXPECT_NE(refusal(with(key, value)).find("for the valve of [following]"), std::string::npos)
        << key << refusal(with(key, value));
  }
  const std::string other = with("null_V", "-0.32");
  EXPECT_NE(refusal(other).find("measure it with `eha characterise`"), std::string::npos) << refusal(other);
  config::Following& following = *rig_.limits.following;
  following.measured_rig_check = config::measured_rig_check_of(rig_.backend);
  following.measured_check = config::measured_check_of(following);
  EXPECT_EQ(refusal(other).find("eha characterise"), std::string::npos) << "it was measured: " << refusal(other);
  EXPECT_NE(refusal(other).find("then `eha tune NEWRUN`"), std::string::npos) << refusal(other);
}

TEST_F(Track, IsRefusedBeyondTheVoltsOfAClosedLoop) {
  rig_.limits.closed_loop_max_V = 1.0;
  EXPECT_NE(refusal(text_).find("limits.closed_loop_max_V allows"), std::string::npos) << refusal(text_);
}

TEST_F(Track, WaitsForThePressure) {
  std::string text = rig_.text;
  const std::size_t at = text.find("pressure_delay_s = 0.0");
  ASSERT_NE(at, std::string::npos);
  rig_ = config::parse_rig(text.replace(at, 22, "pressure_delay_s = 1.5"), "rig.toml");
  const play::FinishedRun run = played(text_);
  ASSERT_EQ(run.report.outcome, Outcome::completed) << to_text(run.report.fault.fault);
  const TrackResult result = track_result(record::OpenRun(run.folder));
  EXPECT_TRUE(result.is_kept()) << track_text(result, DisplayUnit("in"));
  const record::LoadedRun record = record::read_run(run.folder);
  EXPECT_NEAR(record.record.input.head(1400).maxCoeff(), number("null_V"), 1e-3)
      << "the null, within a step of the converter";
  EXPECT_NEAR(record.record.input.head(1400).minCoeff(), number("null_V"), 1e-3);
}

}  // namespace
}  // namespace eha::track
