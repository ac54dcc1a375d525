// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/section.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

/// A run whose model has a map with the null at 0.031 V, on a rig whose valve sheet has it elsewhere.
std::string page_with_nulls(double by_sheet_V, double map_error_V = 0.0) {
  Subject subject = subject_of("run", ident::Grade::good);
  ident::Model& model = subject.models[0].model;
  model.input_unit = "V";
  model.input_map = ident::ValveMap{.null = 0.031, .dead_band = 0.15, .negative_gain_ratio = 1.0};
  model.parameters.push_back({.name = "null",
                              .value = 0.031,
                              .std = 0.001,
                              .lower95 = 0.029,
                              .upper95 = 0.033,
                              .role = ident::ParameterRole::valve_null});
  subject.manifest.emplace();
  (*subject.manifest)["rig"]["following"] = {
      {"null_V", by_sheet_V}, {"null_uncertainty_V", 0.008}, {"measured_check", 1}};
  if (map_error_V > 0.0) {
    if (!model.validation) model.validation.emplace();
    model.validation->map_error = map_error_V;
  }
  return page_of(subject).html;
}

TEST(PageJudgement, ComparesTheNullWithTheValveSheets) {
  const std::string agree = page_with_nulls(0.037);
  EXPECT_NE(agree.find("null 0.0310 ± 0.0020 V here and 0.0370 ± 0.0080 V there, they agree."), std::string::npos);
  EXPECT_EQ(agree.find("Trust the valve sheet"), std::string::npos);
  const std::string apart = page_with_nulls(0.07);
  EXPECT_NE(apart.find("they differ by 0.039, more than the 0.023 that the intervals and the straight lines"),
            std::string::npos);
  EXPECT_NE(apart.find("Trust the valve sheet"), std::string::npos);
}

TEST(PageJudgement, AllowsANullWhatTheErrorOfItsMapMoves) {
  const std::string html = page_with_nulls(0.07, 0.04);
  EXPECT_EQ(html.find("Trust the valve sheet"), std::string::npos);
  EXPECT_NE(html.find("they agree within the 0.088 that the straight lines of the map allow"), std::string::npos);
  EXPECT_NE(html.find("half dead band of the fit may be up to 0.08 V off the valve&#39;s"), std::string::npos);
}

TEST(PageJudgement, SaysBesideNullAndDeadBandThatTheyAreNotTheValvesAndCompensatesNothingByThem) {
  const std::string html = page_with_nulls(0.07, 0.04);
  const std::string box = html.substr(0, html.find("</section>"));
  EXPECT_NE(box.find("half dead band of the fit may be up to 0.08 V off the valve&#39;s"), std::string::npos) << box;
  EXPECT_EQ(html.find("A controller can compensate it: add"), std::string::npos);
  EXPECT_NE(html.find("Compensate nothing by these numbers"), std::string::npos);
  const std::string less = page_with_nulls(0.07, 0.02);
  EXPECT_NE(less.find("may be up to 0.04 V off"), std::string::npos) << "what the terminal says, too";
  EXPECT_EQ(less.find("A controller can compensate it: add"), std::string::npos);
  const std::string sound = page_with_nulls(0.037, 0.01);
  EXPECT_EQ(sound.find("off the valve&#39;s"), std::string::npos);
  EXPECT_NE(sound.find("A controller can compensate it: add"), std::string::npos);
}

TEST(PageJudgement, NamesTheDeadBandThatChangedAndNoNullThatDidNot) {
  // A valve whose dead band grew to 0.209 V; a null within its method's error.
  Subject subject = subject_of("run", ident::Grade::good);
  ident::Model& model = subject.models[0].model;
  model.input_unit = "V";
  model.output_unit = "mm";
  model.input_map = ident::ValveMap{.null = -0.206, .dead_band = 0.209, .negative_gain_ratio = 0.877};
  model.transfer_function = {{{25.4 * 0.1511, 0.0}}, {{0.0, 0.0}, {1.0, 1.0}}, 0.0};
  const auto add = [&](const char* name, double value, ident::ParameterRole role) {
    model.parameters.push_back({name, value, 0.0004, value - 0.0008, value + 0.0008, false, role});
  };
  add("null", -0.206, ident::ParameterRole::valve_null);
  add("dead_band", 0.209, ident::ParameterRole::dead_band);
  add("negative_gain_ratio", 0.877, ident::ParameterRole::negative_gain_ratio);
  add("K", 25.4 * 0.1511, ident::ParameterRole::numerator_coefficient);
  subject.manifest.emplace();
  (*subject.manifest)["rig"]["following"] = {{"null_V", -0.2},
                                             {"null_uncertainty_V", 0.004},
                                             {"dead_band_V", 0.2},
                                             {"dead_band_uncertainty_V", 0.004},
                                             {"gain_positive_in_per_V_s", 0.074},
                                             {"gain_negative_in_per_V_s", 0.065},
                                             {"gain_uncertainty_percent", 1.0},
                                             {"measured_check", 1}};
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("The valve has changed since its sheet, or is another one: half dead band."), std::string::npos);
  EXPECT_NE(html.find("they differ by 0.059"), std::string::npos);
  EXPECT_NE(html.find("V there (dead_band_V = 0.2 with 0.05 V to spare), they differ"), std::string::npos) << html;
  EXPECT_EQ(html.find("Trust the valve sheet"), std::string::npos);
  EXPECT_NE(html.find("mm/(V s) there, they agree"), std::string::npos);
  const std::string box = html.substr(0, html.find("<details"));
  EXPECT_NE(
      box.find("<strong>The rig is not as the valve sheet in its rig file says: half dead band 0.21 V, on the sheet "
               "0.15.</strong>"),
      std::string::npos)
      << box;
  EXPECT_NE(box.find("Next: <code>eha characterise -o rig-new.toml</code>"), std::string::npos) << box;
  EXPECT_EQ(html.find("A controller can compensate it: add"), std::string::npos) << "by which of the two?";

  (*subject.manifest)["rig"]["following"]["dead_band_V"] = 0.26;
  (*subject.manifest)["rig"]["following"]["gain_positive_in_per_V_s"] = 0.1;
  (*subject.manifest)["rig"]["following"]["gain_negative_in_per_V_s"] = 0.088;
  const std::string weaker = page_of(subject).html;
  EXPECT_NE(weaker.find("says: gain 3.8 mm/(V s), on the sheet 5.1."), std::string::npos) << weaker.substr(0, 8000);
  EXPECT_NE(weaker.find("Look at the supply pressure first"), std::string::npos);

  (*subject.manifest)["rig"]["following"].erase("measured_check");
  const std::string typed = page_of(subject).html;
  EXPECT_NE(typed.find("The rig is not as [following] of its rig file says: gain 3.8 mm/(V s), there 5.1."),
            std::string::npos);
  EXPECT_EQ(typed.find("sheet in its rig file"), std::string::npos) << "nobody made a sheet";
  EXPECT_NE(typed.find("Beside [following] of the rig file"), std::string::npos);

  // Warm oil moves a null a little; not by 0.2 V.
  (*subject.manifest)["rig"]["following"]["null_V"] = -0.15;
  EXPECT_EQ(page_of(subject).html.find("says: null"), std::string::npos);
  (*subject.manifest)["rig"]["following"]["null_V"] = 0.0;
  EXPECT_NE(page_of(subject).html.find("The rig is not as [following] of its rig file says: null -0.21 V, there 0;"),
            std::string::npos);
}

TEST(PageJudgement, SaysThatASmallErrorIsNoNoise) {
  Subject subject = subject_of("run", ident::Grade::usable);
  for (double& y : subject.fit.models[0].simulated) y -= 0.01;
  const auto to_do = [&] {
    const std::string html = page_of(subject).html;
    const std::size_t at = html.find("<dt>To do</dt><dd>") + 18;
    return html.substr(at, html.find("</dd>", at) - at);
  };
  EXPECT_EQ(to_do(), "Nothing.");
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.007, .limit = 0.01});
  EXPECT_NE(to_do().find("it follows the input. Nothing, where "), std::string::npos) << to_do();
  for (std::size_t i = 0; i < 100; ++i) subject.fit.models[0].simulated[i] += (i < 50 ? 1e-4 : 2e-4) * (i % 2 ? 1 : -1);
  EXPECT_NE(to_do().find("it is larger on the unseen part and follows the input."), std::string::npos) << to_do();
}

/// The notes beside the first plot and beside the residual's.
std::vector<std::string> to_do_of(const Subject& subject) {
  const std::string html = page_of(subject).html;
  std::vector<std::string> found;
  const std::string begin = "<dt>To do</dt><dd>";
  for (std::size_t at = html.find(begin); at != std::string::npos; at = html.find(begin, at + 1)) {
    const std::size_t from = at + begin.size();
    found.push_back(html.substr(from, html.find("</dd>", from) - from));
  }
  return found;
}

TEST(PageJudgement, GivesARemedyInTheBoxAlone) {
  Subject subject = subject_of("run", ident::Grade::usable);
  for (double& y : subject.fit.models[0].simulated) y += 0.3;
  ident::Verdict& verdict = *subject.models[0].model.verdict;
  verdict.criteria.push_back({.kind = ident::CriterionKind::residual_input, .value = 1e-6, .limit = 0.01});
  verdict.reasons = {"The input still moves what the model leaves over; take io3_valve."};
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "io_gain_dB", "io_phase_deg"};
  response.columns = {{0.05, 0.2}, {1.0, 1.0}, {0.0, 0.0}, {0.0, 0.0}, {3.0, 3.0}, {0.0, 0.0}};
  subject.response = response;
  const std::vector<std::string> notes = to_do_of(subject);
  const std::string html = page_of(subject).html;
  EXPECT_EQ(html.find("Try --"), std::string::npos);
  EXPECT_EQ(count(html, "take io3_valve"), 1U);
  EXPECT_EQ(std::count_if(notes.begin(), notes.end(),
                          [](const std::string& note) {
                            return note.find("misses a part of the plant") != std::string::npos &&
                                   note.ends_with(": the box above says what to do.");
                          }),
            3)
      << "beside the plots over time, of the frequencies and of the residual";
}

TEST(PageJudgement, SaysHowNearTheModelIsWithinItsUsableBand) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.models[0].model.verdict->usable_band = ident::FrequencyInterval{0.01, 0.1};
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "io_gain_dB", "io_phase_deg"};
  response.columns = {{0.05, 0.2}, {1.0, 1.0}, {0.0, 0.0}, {0.0, 0.0}, {0.1, 6.0}, {1.0, 40.0}};
  subject.response = response;
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("io is within 6 dB and 40 deg of the measured response."), std::string::npos);
  EXPECT_NE(html.find("Within the usable band it is within 0.1 dB and 1 deg."), std::string::npos);
}

TEST(PageJudgement, CallsAPlantNotLinearBesideTheResidualWhereTheBoxDoes) {
  Subject subject = subject_of("run", ident::Grade::usable);
  ident::Model& model = subject.models[0].model;
  model.validation->tests.emplace();
  model.validation->tests->input = {.statistic = 40.0, .degrees = 20, .p = 0.006};
  model.validation->tests->nonlinearity =
      ident::NonlinearityTest{{.statistic = 200.0, .degrees = 6, .p = 1e-21}, ident::NonlinearKind::motion};
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::residual_input, .value = 0.006, .limit = 0.01});
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::nonlinearity, .value = 1e-21, .limit = 0.002});
  const std::vector<std::string> notes = to_do_of(subject);
  EXPECT_EQ(std::count(notes.begin(), notes.end(), "The plant is not linear: the box above says what to do."), 1);
  for (const std::string& note : notes) EXPECT_EQ(note.find("misses a part"), std::string::npos) << note;
}

TEST(PageJudgement, SaysNothingToDoOfNoSectionWhereTheBoxAsksForSomethingFirst) {
  Subject subject = subject_of("run", ident::Grade::good);
  std::vector<std::string> notes = to_do_of(subject);
  const auto nothing = [&] { return std::count(notes.begin(), notes.end(), "Nothing."); };
  ASSERT_GE(nothing(), 1);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  ASSERT_EQ(subject.next_step().first, ident::FirstStep::longer_record);
  notes = to_do_of(subject);
  EXPECT_GE(std::count(notes.begin(), notes.end(), "Nothing here; what comes first the box above says."), 1);
}

TEST(PageJudgement, NamesInTheBoxAllThatLimitsAModel) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.has_recommendation = true;
  ident::Model& model = subject.models[0].model;
  model.validation->tests.emplace().input = {.statistic = 40.0, .degrees = 21, .p = 0.0066};
  model.validation->tests->nonlinearity =
      ident::NonlinearityTest{{.statistic = 300.0, .degrees = 12, .p = 1e-21}, ident::NonlinearKind::motion};
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::nonlinearity, .value = 1e-21, .limit = 0.002});
  model.verdict->criteria.push_back({.kind = ident::CriterionKind::residual_input, .value = 0.0066, .limit = 0.01});
  model.verdict->reasons = ident::reasons_of(model, *model.verdict);
  ASSERT_EQ(model.verdict->reasons.size(), 1U);
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("<li>By the same cause the input moves the error (p = 0.0066).</li>"), std::string::npos);
}

TEST(PageJudgement, SaysTheSameOfAnErrorBesideItsPicturesAsInTheBox) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  for (double& y : subject.fit.models[0].simulated) y += 0.3;
  ident::Model& model = subject.models[0].model;
  model.validation->jump = ident::ErrorJump{.time_s = 2.0, .change = 0.3};
  std::vector<std::string> notes = to_do_of(subject);
  EXPECT_EQ(notes.at(0).rfind("The error jumps", 0), 0U) << notes[0];
  model.validation->jump.reset();
  model.validation->end_stop = ident::EndStop{.level = 1.0, .percent = 40.0};
  notes = to_do_of(subject);
  EXPECT_EQ(notes.at(0).rfind("The output stands at an end", 0), 0U) << notes[0];
  model.validation->end_stop.reset();
  model.validation->ljung_box_p = 0.5;
  for (const auto kind : {ident::CriterionKind::residual_input, ident::CriterionKind::residual_whiteness}) {
    model.verdict->criteria.push_back({.kind = kind, .value = 0.5, .limit = 0.01, .passed = true});
  }
  model.verdict->criteria[0].passed = false;  // R2
  notes = to_do_of(subject);
  EXPECT_EQ(std::count_if(notes.begin(), notes.end(),
                          [](const std::string& note) { return note.rfind("What is left is plain noise", 0) == 0; }),
            2)
      << "beside the plots over time and of the residual";
}

TEST(PageJudgement, SaysWhereBarsOfTheGainErrorDoNotHold0) {
  Subject subject = subject_of("run", ident::Grade::good);
  const ident::Model& model = subject.models[0].model;
  const std::vector<double> f{0.05, 0.2, 0.6};
  const ident::BodeCurve curve = ident::bode_curve(model, f, {});
  record::NumberTable response;
  response.names = {"frequency_Hz",           "gain", "gain_dB", "phase_deg", "std", model.name + "_gain_dB",
                    model.name + "_phase_deg"};
  response.columns = {f, {}, {}, curve.phase_deg, {}, curve.gain_dB, curve.phase_deg};
  for (std::size_t i = 0; i < f.size(); ++i) {
    response.columns[2].push_back(curve.gain_dB[i] + (i == 0 ? 0.0 : 0.3));
    response.columns[1].push_back(std::pow(10.0, response.columns[2].back() / 20.0));
    response.columns[4].push_back(0.001 * response.columns[1].back());
  }
  subject.response = response;
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("The bars of 2 of the 3 lines do not hold 0"), std::string::npos);
  EXPECT_NE(html.find("Use the model where an error of 0.3 dB does not matter"), std::string::npos);
  EXPECT_EQ(html.find("Nothing. To learn the response"), std::string::npos);
}

TEST(PageJudgement, NamesTheCriteriaInWordsWithTheirUnits) {
  Subject subject = subject_of("run", ident::Grade::usable);
  ident::Verdict& verdict = *subject.models[0].model.verdict;
  verdict.usable_band = ident::FrequencyInterval{0.05, 0.65};
  verdict.criteria.push_back({.kind = ident::CriterionKind::residual_input, .value = 0.007, .limit = 0.01});
  ident::Model& other = subject.models.emplace_back(subject.models[0]).model;
  other.name = "io3";
  other.verdict->accepted = false;
  other.verdict->grade = ident::Grade::rejected;
  other.verdict->criteria.push_back({.kind = ident::CriterionKind::coefficient_interval, .parameter = "a0"});
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find(">R2, validation</td>"), std::string::npos);
  EXPECT_NE(html.find(">%</td>"), std::string::npos);
  EXPECT_NE(html.find(">validation_r2_percent</td>"), std::string::npos);
  EXPECT_NE(html.find("as far as noise goes; they can be off by what the model misses"), std::string::npos);
  EXPECT_NE(html.find("its file lies in models/rejected"), std::string::npos);
  EXPECT_NE(html.find("<span class=\"fraction\">"), std::string::npos);
}

}  // namespace
}  // namespace eha::report
