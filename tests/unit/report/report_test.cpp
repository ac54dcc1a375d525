// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/report/comparison_page.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/model_file.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "ident/validation/verdict.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

TEST(Escaped, LeavesNoMarkupAndNoBrokenText) {
  EXPECT_EQ(escaped("<a href='x'>&\"b\""), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;b&quot;");
  EXPECT_EQ(escaped("\xC3\xA9 \xC3( \xFF\x01"), "\xC3\xA9 ?( ? ");
}

TEST(WithCode, ShowsWhatStandsBetweenBackticksAsCode) {
  EXPECT_EQ(with_code("`eha fit <a>` or `b`"), "<code>eha fit &lt;a&gt;</code> or <code>b</code>");
  EXPECT_EQ(with_code("one ` alone"), "one ` alone");
  EXPECT_EQ(with_code("0.2 +- 0.1 V, `eha fit +-.csv`, +-5"), "0.2 ± 0.1 V, <code>eha fit +-.csv</code>, ±5");
  EXPECT_EQ(paragraph("`a`"), "<p><code>a</code></p>\n");
}

TEST(Page, BeginsWithTheRecommendedModelAndItsReason) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.has_recommendation = true;
  subject.reason = "Least AR-BIC of two models.";
  const std::string html = page_of(subject).html;
  const std::size_t recommended = html.find("Recommended model: io (good)");
  ASSERT_NE(recommended, std::string::npos);
  EXPECT_LT(recommended, html.find("<svg"));
  EXPECT_NE(html.find("Least AR-BIC of two models."), std::string::npos);
}

TEST(Page, SaysThatNoModelCanBeUsedAndWhy) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  subject.manifest.emplace();
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("No model can be used"), std::string::npos);
  EXPECT_EQ(html.find("Recommended model"), std::string::npos);
  EXPECT_NE(html.find("The error &lt;exceeds&gt; its &quot;limit&quot; &amp; more."), std::string::npos);
}

TEST(Page, ShowsTheFirstReasonOfARejectionInFullAndFoldsTheModel) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  subject.models[0].model.verdict->reasons = {"The model does not follow: R2 is low; record longer.",
                                              "The plant is not linear (p = 0.001): so it is; use it no more."};
  const std::string html = page_of(subject).html;
  const std::string box = html.substr(0, html.find("</section>"));
  const std::size_t fold = box.find("<details");
  ASSERT_NE(fold, std::string::npos) << box;
  EXPECT_LT(box.find("R2 is low; record longer."), fold);
  EXPECT_LT(box.find("The plant is not linear"), fold);
  EXPECT_GT(box.find("use it no more"), fold);
  EXPECT_GT(box.find("class=\"equation\""), fold);
}

TEST(Page, ShowsEachReasonWithoutFiguresOnce) {
  Subject subject = subject_of("fo", ident::Grade::rejected);
  subject.models[0].model.verdict->reasons = {"It does not need a2; use the model without it.",
                                              "It does not need a0; use the model without it.",
                                              "It hardly determines n2; use fewer parameters."};
  const std::string html = page_of(subject).html;
  const std::string box = html.substr(0, html.find("</section>"));
  EXPECT_EQ(count(box, "It does not need a0"), 1U) << box;
  EXPECT_EQ(count(box, "It hardly determines n2; use fewer parameters."), 1U);
  EXPECT_NE(box.find("That model in figures"), std::string::npos);
}

TEST(Page, SaysTheReasonOfARejectionOnce) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  subject.models[0].model.verdict->reasons = {"The rod stands at an end; cut with --from 37.", "R2 is too low."};
  subject.reason = "io, the best one, is rejected: The rod stands at an end; cut with --from 37.";
  const std::string html = page_of(subject).html;
  EXPECT_EQ(count(html, "The rod stands at an end; cut with"), 1U);
  subject.reason = "io, the best one, is rejected: The rod stands at an end";
  EXPECT_EQ(count(page_of(subject).html, "The rod stands at an end"), 1U) << "a quoted statement";
  EXPECT_NE(html.find("<li>R2 is too low.</li>"), std::string::npos);
}

TEST(Page, CallsACompletedRunWithoutModelsNoPartialRecord) {
  Subject subject{.name = "characterise"};
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "completed";
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("No model in this run"), std::string::npos);
  EXPECT_EQ(html.find("partial record"), std::string::npos);
}

TEST(Page, ShowsWhatAnEndedTrialShowed) {
  Subject subject{.name = "track"};
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["experiment"]["track"] = "axis";
  subject.trial_changes = {"dead band 0.303 V instead of 0.151 V"};
  std::string html = page_of(subject).html;
  EXPECT_NE(html.find("dead band 0.303 V instead of 0.151 V"), std::string::npos);
  EXPECT_NE(html.find("where its sheet shows a leak"), std::string::npos);
  subject.leak = ident::Leak{0.0171, 0.14};
  html = page_of(subject).html;
  EXPECT_NE(
      html.find("<p>Oil leaks past the piston or through the valve: by the valve sheet the rod creeps at 0.017 in/s"),
      std::string::npos);
  EXPECT_EQ(html.find("is not the one that the controller was made for"), std::string::npos);
}

TEST(Page, SaysWhyTheRunOfItsModelsEndedEarly) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["report"]["description"] = "travel_limit at 39.5 s: 5.7 in";
  EXPECT_NE(page_of(subject).html.find("did not complete (faulted: travel_limit at 39.5 s: 5.7 in)"),
            std::string::npos);
  (*subject.manifest)["outcome"] = "completed";
  EXPECT_EQ(page_of(subject).html.find("did not complete"), std::string::npos);
}

TEST(Equation, NamesNoEndOfAFreeResponseThatTheRecordDoesNotShow) {
  ident::Model model = model_named("io", ident::Grade::usable, 99.0);
  model.initial_output = 20.4;
  model.initial_state = {-17.4};
  model.estimation->score.mse = 1e-4;
  ident::ParameterEstimate end{.name = "initial_output", .value = 20.4, .std = 3.8, .lower95 = 12.8, .upper95 = 28.0};
  end.role = ident::ParameterRole::initial_output;
  model.parameters.push_back(end);
  EXPECT_EQ(equation(model).find("20.4"), std::string::npos);
  model.parameters.back().lower95 = 20.38;
  model.parameters.back().upper95 = 20.42;
  EXPECT_NE(equation(model).find("a free response that ends at 20.4"), std::string::npos);
}

TEST(Page, ShowsTheRemarksOnItsRecord) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  subject.models[0].model.provenance["remarks"] = "the output stays at 75\nsecond";
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("<li>the output stays at 75</li>"), std::string::npos);
  EXPECT_NE(html.find("<li>second</li>"), std::string::npos);
}

TEST(Page, DrawsATravelLimitThatTheRodCameNear) {
  Subject subject = subject_of("run", ident::Grade::good);
  EXPECT_EQ(page_of(subject).html.find("travel limit"), std::string::npos) << "of no rig";
  subject.manifest.emplace();
  (*subject.manifest)["rig"]["limits"] = {{"travel_min_in", -3.0}, {"travel_max_in", 1.1}};
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("travel limit, 1.1 in"), std::string::npos);
  EXPECT_EQ(html.find("travel limit, -3 in"), std::string::npos) << "far from the record";
}

TEST(Page, PutsThreeSentencesBesideEveryPlot) {
  const Page page = page_of(subject_of("run", ident::Grade::good));
  EXPECT_TRUE(page.missing.empty());
  const std::size_t plots = count(page.html, "<svg");
  EXPECT_GE(plots, 5U);
  EXPECT_EQ(count(page.html, "<dt>Seen here</dt>"), plots);
  EXPECT_EQ(count(page.html, "<dt>How it should look</dt>"), plots);
  EXPECT_EQ(count(page.html, "<dt>To do</dt>"), plots);
}

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

TEST(Page, ComparesTheNullWithTheValveSheets) {
  const std::string agree = page_with_nulls(0.037);
  EXPECT_NE(agree.find("null 0.0310 ± 0.0020 V here and 0.0370 ± 0.0080 V there, they agree."), std::string::npos);
  EXPECT_EQ(agree.find("Trust the valve sheet"), std::string::npos);
  const std::string apart = page_with_nulls(0.07);
  EXPECT_NE(apart.find("they differ by 0.039, more than the 0.023 that the intervals and the straight lines"),
            std::string::npos);
  EXPECT_NE(apart.find("Trust the valve sheet"), std::string::npos);
}

TEST(Page, AllowsANullWhatTheErrorOfItsMapMoves) {
  const std::string html = page_with_nulls(0.07, 0.04);
  EXPECT_EQ(html.find("Trust the valve sheet"), std::string::npos);
  EXPECT_NE(html.find("they agree within the 0.088 that the straight lines of the map allow"), std::string::npos);
  EXPECT_NE(html.find("half dead band of the fit may be up to 0.08 V off the valve&#39;s"), std::string::npos);
}

TEST(Page, SaysBesideNullAndDeadBandThatTheyAreNotTheValvesAndCompensatesNothingByThem) {
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

TEST(Page, NamesTheDeadBandThatChangedAndNoNullThatDidNot) {
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

TEST(Page, SaysThatASmallErrorIsNoNoise) {
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

TEST(Page, GivesARemedyInTheBoxAlone) {
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

TEST(Page, SaysHowNearTheModelIsWithinItsUsableBand) {
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

TEST(Page, CallsAPlantNotLinearBesideTheResidualWhereTheBoxDoes) {
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

TEST(Page, SaysNothingToDoOfNoSectionWhereTheBoxAsksForSomethingFirst) {
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

TEST(Page, NamesInTheBoxAllThatLimitsAModel) {
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

TEST(Page, SaysTheSameOfAnErrorBesideItsPicturesAsInTheBox) {
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

TEST(Page, SaysWhereBarsOfTheGainErrorDoNotHold0) {
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

TEST(Page, NamesTheCriteriaInWordsWithTheirUnits) {
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

TEST(Page, BeginsWithTheEquationThenSaysHowFarToTrustItAndWhatToDoNext) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.has_recommendation = true;
  subject.models[0].model.output_unit = "in";
  subject.models[0].model.validation->score.r2_percent = 99.998;
  const std::string html = page_of(subject).html;
  const std::size_t error = html.find("rms error 0.01 in, at most 0.05 in");
  ASSERT_NE(error, std::string::npos);
  EXPECT_NE(html.find("R2 above 99.99 %"), std::string::npos) << "no model is perfect";
  const std::size_t grade = html.find("Usable: no check rejects it");
  const std::size_t next = html.find("Next: ");
  EXPECT_LT(error, grade);
  EXPECT_LT(grade, next);
  EXPECT_LT(html.find("class=\"equation\""), error);
  EXPECT_NE(html.find("eha export models/io.json --format octave"), std::string::npos);
  EXPECT_EQ(html.find("eha tune"), std::string::npos) << "of model files";
}

TEST(Page, DescribesTheOtherModelsAfterThePicturesOfTheFirst) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.models.push_back({model_named("io3", ident::Grade::rejected, 95.0), "models/rejected/io3.json"});
  subject.models[1].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::coefficient_interval, .parameter = "a3"});
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::nonlinearity, .value = 5.9e-21, .limit = 0.002});
  const std::string html = page_of(subject).html;
  EXPECT_GT(html.find("io3: rejected"), html.find("Parameters of io"));
  EXPECT_NE(html.find("a3 may be 0"), std::string::npos);
  EXPECT_NE(html.find("&lt; 0.0001"), std::string::npos) << "a probability has no twenty digits";
}

TEST(Page, LeavesTheTableOfModelsRoomForItsNotes) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.models[0].model.verdict->criteria.front().value = 99.996;
  const std::string html = page_of(subject).html;
  const std::string shown =
      html.substr(html.find("<h2>Models</h2>"), html.find("<summary>Estimating part") - html.find("<h2>Models</h2>"));
  EXPECT_NE(shown.find(">90.0</td>"), std::string::npos) << "the fit as the terminal has it: " << shown;
  EXPECT_EQ(shown.find("AR-BIC"), std::string::npos) << shown;
  EXPECT_NE(html.find("<summary>Estimating part, parameters and AR-BIC of every model</summary>"), std::string::npos);
  EXPECT_NE(html.find(">above 99.99</td>"), std::string::npos) << "of the check too";
}

TEST(Page, FoldsWhatIsLookedUpBehindWhatAReaderNeedsFirst) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.has_recommendation = true;
  subject.models.push_back({model_named("io3", ident::Grade::rejected, 95.0), "models/rejected/io3.json"});
  const std::string html = page_of(subject).html;
  const std::size_t box_fold = html.find("<details");
  EXPECT_LT(html.find("Recommended model: io"), box_fold);
  EXPECT_LT(html.find("Next: "), box_fold);
  EXPECT_LT(html.find("class=\"equation\""), box_fold);
  const std::size_t first_fold = html.find("<details", box_fold + 1);
  ASSERT_NE(first_fold, std::string::npos);
  EXPECT_EQ(html.find("<details class=\"section\" open"), std::string::npos);
  for (const char* open : {"Recommended model: io", "<h2>Over time</h2>", "<h2>Models</h2>"}) {
    EXPECT_LT(html.find(open), first_fold) << open;
  }
  for (const char* title : {"Stability", "Parameters", "The other models"}) {
    EXPECT_NE(html.find(std::string("<summary>") + title + "</summary>"), std::string::npos) << title;
  }
  EXPECT_NE(html.find("<summary>Every check of io</summary>"), std::string::npos);
  // Without a model they are all that the page has.
  Subject ended{.name = "run"};
  ended.manifest.emplace();
  (*ended.manifest)["outcome"] = "faulted";
  EXPECT_EQ(page_of(ended).html.find("<details"), std::string::npos);
}

TEST(Page, SaysOnceThatARunWasInterruptedAndWhatToCorrectFirst) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "interrupted";
  (*subject.manifest)["report"]["description"] = "interrupted by a stop request; the command was ramped out";
  EXPECT_NE(page_of(subject).html.find("did not complete (interrupted by a stop request; the"), std::string::npos);
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["report"]["description"] = "travel_limit at 3 s";
  EXPECT_NE(page_of(subject).html.find("did not complete (faulted: travel_limit at 3 s)"), std::string::npos);
  Subject ended{.name = "run"};
  ended.manifest = subject.manifest;
  const std::string none = page_of(ended).html;
  EXPECT_NE(none.find("The run ended before its first row"), std::string::npos) << none;
  EXPECT_EQ(none.find("eha fit"), std::string::npos) << "nothing to fit";
  ended.record.emplace();
  ended.record->step_s = 0.1;
  ended.record->input = ended.record->output = Eigen::VectorXd::LinSpaced(30, 0.0, 1.0);
  const std::string part = page_of(ended).html;
  EXPECT_LT(part.find("Correct what ended the run; then record again."), part.find("eha fit"));
}

TEST(Page, NamesTheLargestErrorOfBothPartsApart) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.fit.models[0].simulated[10] = subject.fit.measured[10] - 0.5;
  subject.fit.models[0].simulated[80] = subject.fit.measured[80] - 0.25;
  const std::string html = page_of(subject).html;
  EXPECT_NE(
      html.find("The largest error of io is 0.25 in at 3.2 s on the unseen part, and 0.5 in at 0.4 s where it was "
                "estimated; the greater is "),
      std::string::npos)
      << html.substr(html.find("The largest error"), 200);
}

TEST(Page, DrawsTheRunnerUpWhereverItStandsInTheTable) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.models = {{model_named("a", ident::Grade::good, 99.0), "a.json"},
                    {model_named("b", ident::Grade::usable, 99.0), "b.json"},
                    {model_named("c", ident::Grade::rejected, 99.0), "c.json"}};
  subject.has_recommendation = true;
  subject.runner_up = "c";
  ASSERT_EQ(subject.pictured().size(), 2U);
  EXPECT_EQ(subject.pictured()[1]->model.name, "c");
  EXPECT_NE(page_of(subject).html.find("the recommended model, a, and its runner-up, c, alone"), std::string::npos);
}

TEST(Page, SaysReasonsInFewWordsBeforeTheirFigures) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.models[0].model.verdict->reasons = {
      "The input still moves what the model leaves over (p = 0.0066, lags up to 20): a part of the plant may be "
      "missing; ignore it where an error of 0.01 in (rms) does not matter."};
  const std::string html = page_of(subject).html;
  const std::size_t few = html.find("leaves over: a part of the plant may be missing.");
  ASSERT_NE(few, std::string::npos) << html.substr(0, html.find("</section>"));
  EXPECT_LT(few, html.find("<details"));
  EXPECT_GT(html.find("p = 0.0066"), html.find("<details"));
}

TEST(Page, CallsAnIntervalALeastOneWhereAPartMayBeMissing) {
  Subject subject = subject_of("run", ident::Grade::usable);
  ident::Model& model = subject.models[0].model;
  model.input_map = ident::ValveMap{-0.4, 0.3, 0.9};
  model.parameters.push_back({"null", -0.4, 0.005, -0.41, -0.39, false, ident::ParameterRole::valve_null});
  EXPECT_NE(equation(model).find("null -0.4000 ± 0.0100 V"), std::string::npos) << equation(model);
  model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::nonlinearity, .value = 1e-5, .limit = 0.002, .passed = false});
  EXPECT_NE(equation(model).find("null -0.4000 ± at least 0.0100 V"), std::string::npos) << equation(model);
  EXPECT_NE(page_of(subject).html.find("lower 95 %, at most"), std::string::npos);
}

TEST(Page, OffersTheLongerExperimentOfAShortRecordBeforeAController) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.has_recommendation = true;
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "completed";
  EXPECT_NE(page_of(subject).html.find("eha tune"), std::string::npos);
  (*subject.manifest)["identification"]["next_experiment"]["file"] = "next_experiment.toml";
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 0.5, .limit = 0.01, .judged = false});
  const std::string html = page_of(subject).html;
  EXPECT_EQ(html.find("eha tune"), std::string::npos);
  EXPECT_NE(html.find("Next: first <code>eha run next_experiment.toml</code>"), std::string::npos);
  EXPECT_NE(html.find("Usable band: none"), std::string::npos);
}

TEST(Page, PicturesTheRecommendedModelAloneWhereThereIsNoRunnerUp) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.models = {{model_named("a", ident::Grade::good, 99.0), "a.json"},
                    {model_named("b", ident::Grade::rejected, 99.0), "b.json"}};
  subject.has_recommendation = true;
  subject.pictured_models = 1;
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("The pictures show the recommended model, a, alone"), std::string::npos);
  EXPECT_EQ(html.find("Poles of b"), std::string::npos);
  subject.pictured_models = 2;
  EXPECT_NE(page_of(subject).html.find("Poles of b"), std::string::npos);
}

TEST(Page, DoesNotAskToAllowAnIntegratorThatIsAccepted) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.models[0].model.transfer_function.denominator = {{0.0132, 2.0}, {1.0, 1.0}};
  EXPECT_NE(page_of(subject).html.find("and the limits of [acceptance] allow it"), std::string::npos);
  subject.models[0].model.verdict->accepted = false;
  EXPECT_NE(page_of(subject).html.find("Accept it with require_stable = false"), std::string::npos);
}

TEST(Page, PrintsWhatIsFoldedWithPageNumbers) {
  const std::string html = page_of(subject_of("run", ident::Grade::good)).html;
  const std::size_t print = html.find("@media print");
  ASSERT_NE(print, std::string::npos);
  EXPECT_NE(html.find("\n  details::details-content { content-visibility: visible;", print), std::string::npos);
  EXPECT_NE(html.find("counter(page) \" / \" counter(pages)"), std::string::npos);
  // The equations of a ladder of other models take pages, and say nothing of the one that is used.
  EXPECT_NE(html.find("#the-other-models::details-content", print), std::string::npos);
}

TEST(Page, BreaksNoOptionBehindItsHyphens) {
  const Section section{
      .title = "s", .items = {{.heading = "h", .html = paragraph("a smaller --decimate, -- or `eha fit --from 3`")}}};
  const std::string html = assembled("t", "", {section}, std::nullopt).html;
  EXPECT_NE(html.find("a smaller <span class=\"option\">--decimate</span>, -- or <code>eha fit --from 3</code></p>"),
            std::string::npos)
      << html.substr(html.find("</style>"));
}

TEST(Page, PutsNoSpanIntoAPicture) {
  plot::Panel panel{.x_label = "time [s]", .y_label = "pos --raw [V]"};
  panel.series.push_back({.label = "pos", .x = {0.0, 1.0}, .y = {0.0, 1.0}});
  const Section section{.title = "s",
                        .items = {{.heading = "h", .figure = plot::Figure{.title = "", .panels = {panel}}}}};
  const std::string html = assembled("t", "", {section}, std::nullopt).html;
  EXPECT_NE(html.find("pos --raw"), std::string::npos) << "gnuplot is missing, or the label is drawn otherwise";
  EXPECT_EQ(html.find("<span class=\"option\">--raw"), std::string::npos);
}

TEST(UtcText, IsNoClockOfAMachine) {
  EXPECT_EQ(utc_text("2026-11-28T21:59:42Z"), "2026-11-28 21:59:42 UTC");
  EXPECT_EQ(utc_text("unknown"), "unknown");
}

TEST(Page, LoadsNothing) {
  const std::string html = page_of(subject_of("run", ident::Grade::good)).html;
  for (const char* loader : {"<script", "src=", "@import", "url(http", "href=\"http", "<link rel=\"stylesheet"}) {
    EXPECT_EQ(html.find(loader), std::string::npos) << loader;
  }
}

TEST(Page, EscapesTheNamesOfFilesAndModels) {
  Subject subject = subject_of("<script>alert(1)</script>", ident::Grade::good);
  subject.models[0].model.name = "<img onerror=x>";
  subject.models[0].model.provenance["note"] = "</style><script>";
  subject.models[0].model.output_unit = "<b>";
  const std::string html = page_of(subject).html;
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  EXPECT_EQ(html.find("<b>"), std::string::npos);
  EXPECT_EQ(count(html, "</style>"), 1U);
}

TEST(Page, IsWrittenWithoutGnuplotAndSaysSo) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const Page page = page_of(subject_of("run", ident::Grade::good));
  setenv("PATH", path.c_str(), 1);
  ASSERT_EQ(page.missing.size(), 1U);
  EXPECT_NE(page.missing[0].find("gnuplot-nox"), std::string::npos);
  EXPECT_NE(page.html.find("This plot is missing"), std::string::npos);
  EXPECT_NE(page.html.find("Model: io (good)"), std::string::npos);
}

}  // namespace
}  // namespace eha::report
