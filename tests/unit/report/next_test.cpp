// SPDX-License-Identifier: GPL-3.0-or-later
// What the box of a report says next.
#include <gtest/gtest.h>

#include <string>

#include "daemon/report/report.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/report/subjects.hpp"

namespace eha::report {
namespace {

/// A run of this outcome with one model.
Subject run_of(const std::string& outcome, ident::Grade grade) {
  Subject subject = subject_of("run", grade);
  subject.folder = "/runs/run";
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = outcome;
  subject.has_recommendation = grade != ident::Grade::rejected;
  return subject;
}

/// The box of the page alone.
std::string box_of(const Subject& subject) {
  const std::string html = page_of(subject).html;
  const std::size_t begin = html.find("<section class=\"verdict");
  return html.substr(begin, html.find("</section>", begin) - begin);
}

TEST(Next, CutsARecordAtItsEndStopAsTheTerminalDoesAndAsksForNoLongerOne) {
  Subject subject = run_of("completed", ident::Grade::usable);
  ident::Model& model = subject.models[0].model;
  model.validation->end_stop = ident::EndStop{.level = 5.7, .from_s = 28.0, .percent = 1.4, .clean_to_s = 27.68};
  model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  (*subject.manifest)["identification"]["next_experiment"]["file"] = "next_experiment.toml";
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("Next: first <code>eha fit /runs/run --to 27.68</code>"), std::string::npos) << box;
  EXPECT_EQ(box.find("next_experiment.toml"), std::string::npos);
  subject = run_of("completed", ident::Grade::rejected);
  subject.models[0].model.provenance[ident::kCutOfRecord] = "--from 3";
  EXPECT_NE(box_of(subject).find("Next: first <code>eha fit /runs/run --from 3</code>"), std::string::npos);
  subject.folder.clear();
  EXPECT_NE(box_of(subject).find("Next: first the same <code>eha fit</code> with <code>--from 3</code>"),
            std::string::npos)
      << "model files know no command";
}

TEST(Next, RecordsWithLessWhereTheOutputSaturates) {
  Subject subject = run_of("completed", ident::Grade::usable);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::saturated, .value = 3.0, .limit = 1.0});
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("Next: first record with smaller amplitudes"), std::string::npos) << box;
  EXPECT_EQ(box.find("too short to judge"), std::string::npos);
}

TEST(Next, LooksAtTheComputerOfARunThatLostTicks) {
  Subject subject = run_of("completed", ident::Grade::rejected);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::interpolated, .value = 1.91, .limit = 1.0, .judged = true});
  subject.models[0].model.provenance[ident::kAgainstLostRows] = ident::kAgainstLateTicks;
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("Next: <code>eha doctor</code> and <code>eha latency --load</code>"), std::string::npos) << box;
}

TEST(Next, TunesWithTheSheetOfTheSameValve) {
  Subject subject = run_of("completed", ident::Grade::good);
  ident::Model& model = subject.models[0].model;
  model.input_unit = "V";
  model.input_map = ident::ValveMap{.null = -0.2, .dead_band = 0.15, .negative_gain_ratio = 0.9};
  EXPECT_EQ(box_of(subject).find("--sheet"), std::string::npos);
  subject.sheet = record::MeasuredValve{.run = "/runs/sheet", .zone = {-0.2, 0.15}};
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("eha tune /runs/run --sheet /runs/sheet"), std::string::npos) << box;
  subject.sheet->zone.dead_band_V = 0.4;
  EXPECT_EQ(box_of(subject).find("--sheet"), std::string::npos) << "of another valve";
}

TEST(Next, PutsANewerSheetIntoTheRigFileAfterATrip) {
  Subject subject = run_of("faulted", ident::Grade::usable);
  (*subject.manifest)["rig"]["following"] = {{"null_V", -0.2}, {"dead_band_V", 0.2}};
  subject.sheet = record::MeasuredValve{.run = "/runs/sheet", .zone = {-0.2, 0.15}};
  EXPECT_EQ(box_of(subject).find("eha characterise"), std::string::npos) << "of which 0.05 V are spare";
  subject.sheet->zone.null_V = 0.1;
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("<code>eha characterise /runs/sheet -o"), std::string::npos) << box;
  EXPECT_NE(box.find("the null of 0.100 V and the dead band of 0.150 V"), std::string::npos) << box;
}

TEST(Next, MeasuresTheValveFirstWhereTheMapIsInDoubt) {
  Subject subject = run_of("completed", ident::Grade::usable);
  ident::Model& model = subject.models[0].model;
  model.input_unit = "V";
  model.input_map = ident::ValveMap{.null = -0.2, .dead_band = 0.15, .negative_gain_ratio = 0.9};
  model.validation->map_error = 0.02;
  EXPECT_EQ(box_of(subject).find("<code>eha characterise"), std::string::npos) << box_of(subject);
  model.validation->map_error = 0.2;
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("Next: <code>eha characterise"), std::string::npos) << box;
  EXPECT_EQ(box.find("eha tune"), std::string::npos) << box;
  subject.sheet_says = ident::SheetSays::is_tight;
  EXPECT_NE(box_of(subject).find("Next: <code>eha tune"), std::string::npos) << box_of(subject);
}

TEST(Next, OffersNoExportOfAGreyBox) {
  Subject subject = run_of("completed", ident::Grade::good);
  subject.models[0].model.grey_box = ident::GreyBox{&ident::friction_kind(), {0.15, 0.02, 0.1}};
  const std::string box = box_of(subject);
  EXPECT_EQ(box.find("eha export"), std::string::npos) << box;
  EXPECT_NE(box.find("<code>eha simulate</code>, with /runs/run/models/io.json"), std::string::npos) << box;
}

TEST(Next, HasWholeCommands) {
  Subject subject = run_of("completed", ident::Grade::good);
  std::string box = box_of(subject);
  EXPECT_NE(box.find("<code>eha tune /runs/run</code>"), std::string::npos) << box;
  EXPECT_NE(box.find("<code>eha export /runs/run/models/io.json --format octave -o plant.m</code>"), std::string::npos);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  (*subject.manifest)["identification"]["next_experiment"]["file"] = "next_experiment.toml";
  (*subject.manifest)["time_base"] = "virtual";
  (*subject.manifest)["rig"]["file"] = "/rigs/sim.toml";
  box = box_of(subject);
  EXPECT_NE(box.find("<code>eha run /runs/run/next_experiment.toml --local --fast --rig /rigs/sim.toml</code>"),
            std::string::npos)
      << box;
  Subject ended{.name = "run", .folder = "/runs/run"};
  ended.manifest = subject.manifest;
  (*ended.manifest)["outcome"] = "interrupted";
  (*ended.manifest)["experiment"]["record"]["discard_s"] = 10.0;
  ended.record.emplace();
  ended.record->step_s = 0.1;
  ended.record->input = ended.record->output = Eigen::VectorXd::LinSpaced(60, 0.0, 1.0);
  // The start alone, which the fit would discard, judges no model.
  EXPECT_EQ(box_of(ended).find("eha fit"), std::string::npos) << box_of(ended);
  (*ended.manifest)["experiment"]["record"]["discard_s"] = 1.0;
  EXPECT_NE(box_of(ended).find("<code>eha fit /runs/run</code>"), std::string::npos) << box_of(ended);
}

TEST(Next, PlaysTheWholeExperimentAgainWhereARunThatEndedEarlyIsTooShort) {
  Subject subject = run_of("faulted", ident::Grade::usable);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  (*subject.manifest)["time_base"] = "virtual";
  (*subject.manifest)["rig"]["file"] = "/rigs/sim.toml";
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("<code>eha run EXPERIMENT.toml --local --fast --rig /rigs/sim.toml</code>, with the file of this "
                     "experiment, to its end"),
            std::string::npos)
      << box;
  EXPECT_EQ(box.find("a longer record"), std::string::npos) << box;
}

TEST(Next, OffersNoFitOfAPartThatIsTooShort) {
  Subject subject{.name = "run", .folder = "/runs/run"};
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["report"]["fault"]["at_s"] = 1.205;
  (*subject.manifest)["experiment"]["record"] = {{"discard_s", 10.0}, {"decimation", 40}, {"split", 0.5}};
  subject.record.emplace();
  subject.record->step_s = 0.001;
  subject.record->input = subject.record->output = Eigen::VectorXd::LinSpaced(1205, 0.0, 1.0);
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("<h2>The run tripped at 1.205 s: no model</h2>"), std::string::npos) << box;
  EXPECT_NE(box.find("is too short to fit"), std::string::npos) << box;
  EXPECT_NE(box.find("Next: correct what ended the run"), std::string::npos) << box;
  EXPECT_EQ(page_of(subject).html.find("eha fit"), std::string::npos);
}

TEST(Next, SaysFirstThatTheRunTripped) {
  Subject subject = run_of("faulted", ident::Grade::usable);
  (*subject.manifest)["report"]["fault"]["at_s"] = 4.354;
  EXPECT_NE(box_of(subject).find("<h2>The run tripped at 4.354 s; of the part before: model io (usable)</h2>"),
            std::string::npos)
      << box_of(subject);
  EXPECT_NE(box_of(subject).find("Next: correct what ended the run; "), std::string::npos);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  EXPECT_NE(box_of(subject).find("correct what ended the run; then <code>eha run EXPERIMENT.toml"), std::string::npos)
      << box_of(subject);
  subject = run_of("faulted", ident::Grade::rejected);
  EXPECT_NE(box_of(subject).find("<h2>The run tripped; of the part before: no model can be used</h2>"),
            std::string::npos);
}

TEST(Next, NamesWhatATrialDidNotWhatNoTrialHas) {
  Subject subject{.name = "track", .folder = "/runs/track"};
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["experiment"]["track"] = "axis";
  (*subject.manifest)["report"]["fault"]["at_s"] = 3.5;
  const std::string box = box_of(subject);
  EXPECT_NE(box.find("<h2>The trial tripped at 3.5 s: the promise is not kept</h2>"), std::string::npos) << box;
  EXPECT_EQ(box.find("No model"), std::string::npos);
  EXPECT_NE(box.find("Next: correct what ended the trial"), std::string::npos);
  EXPECT_NE(box.find("<code>eha plot /runs/track</code>"), std::string::npos);
}

TEST(Next, LeavesOneStatementOfASensorThatShowsNoMotion) {
  Subject subject = run_of("completed", ident::Grade::rejected);
  ident::Model& model = subject.models[0].model;
  model.estimation->score.r2_percent = 0.1;
  model.validation->score.r2_percent = -0.5;
  model.validation->ljung_box_p = 0.5;
  for (const auto kind : {ident::CriterionKind::residual_input, ident::CriterionKind::residual_whiteness}) {
    model.verdict->criteria.push_back({.kind = kind, .value = 0.5, .limit = 0.01, .passed = true});
  }
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("Next: <code>eha read</code>"), std::string::npos);
  EXPECT_EQ(html.find("<dt>"), std::string::npos) << "no remark beside the picture";
  EXPECT_EQ(html.find("Step response"), std::string::npos);
}

TEST(Next, LooksAtTheSensorOfAnOutputThatIsConstant) {
  Subject subject{.name = "run", .folder = "/runs/run"};
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "completed";
  (*subject.manifest)["identification"]["error"] = "record: the output is constant at 2.5 in";
  subject.record.emplace();
  subject.record->step_s = 0.1;
  subject.record->input = Eigen::VectorXd::LinSpaced(30, 0.0, 1.0);
  subject.record->output = Eigen::VectorXd::Constant(30, 2.5);
  const std::string html = page_of(subject).html;
  EXPECT_NE(box_of(subject).find("Next: <code>eha read</code>"), std::string::npos) << box_of(subject);
  EXPECT_EQ(html.find("eha fit"), std::string::npos);
  EXPECT_EQ(html.find("touches neither end"), std::string::npos);
}

TEST(Page, NotesWhatIsNotJudgedWithoutTheSignOfAProbability) {
  Subject subject = run_of("completed", ident::Grade::usable);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  EXPECT_NE(page_of(subject).html.find("not judged whether the input does not move the error<"), std::string::npos);
}

}  // namespace
}  // namespace eha::report
