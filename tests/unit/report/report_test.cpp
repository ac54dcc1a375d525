// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/report.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "core/error.hpp"
#include "daemon/report/comparison_page.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/page.hpp"
#include "daemon/report/section.hpp"
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
