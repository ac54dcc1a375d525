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
#include "ident/model/model_file.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

ident::Model model_named(const std::string& name, ident::Grade grade, double r2_percent) {
  ident::Model model;
  model.name = name;
  model.transfer_function = {{{0.13, 0.0}}, {{0.0132, 2.0}, {1.0, 1.0}, {0.0028, 0.0}}, 0.0};
  model.parameters = {{.name = "K", .value = 0.13, .std = 0.001, .lower95 = 0.128, .upper95 = 0.132},
                      {.name = "a0", .value = 0.0028, .std = 0.003, .lower95 = 0.0, .upper95 = 0.012}};
  model.estimation.emplace().score = {.r2_percent = 99.0, .samples = 50};
  ident::ValidationReport& validation = model.validation.emplace();
  validation.score = {
      .r2_percent = r2_percent, .mse = 1e-4, .fit_percent = 90.0, .error_min = -0.05, .error_max = 0.04, .samples = 50};
  validation.acf = {{0, 1, 2}, {1.0, 0.5, 0.1}, 0.2, 0.3};
  validation.ccf = {{-1, 0, 1}, {0.1, 0.5, 0.1}, 0.2, 0.3};
  model.verdict =
      ident::Verdict{.accepted = grade != ident::Grade::rejected,
                     .reasons = {"The error <exceeds> its \"limit\" & more."},
                     .grade = grade,
                     .criteria = {{ident::CriterionKind::r2, "validation", r2_percent, 90.0, r2_percent > 90.0}}};
  return model;
}

Subject subject_of(const std::string& name, ident::Grade grade) {
  Subject subject{.name = name};
  subject.models.push_back({model_named("io", grade, 99.0), "models/io.json"});
  subject.fit = {.input = {"voltage", "V"},
                 .output = {"displacement", "in"},
                 .time_s = {},
                 .applied = {},
                 .measured = {},
                 .models = {{"io", {}}}};
  for (int i = 0; i < 100; ++i) {
    subject.fit.time_s.push_back(0.04 * i);
    subject.fit.applied.push_back(std::sin(0.1 * i));
    subject.fit.measured.push_back(std::cos(0.1 * i));
    subject.fit.models[0].simulated.push_back(std::cos(0.1 * i) + 0.01);
  }
  return subject;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++found;
  return found;
}

TEST(Escaped, LeavesNoMarkupAndNoBrokenText) {
  EXPECT_EQ(escaped("<a href='x'>&\"b\""), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;b&quot;");
  EXPECT_EQ(escaped("\xC3\xA9 \xC3( \xFF\x01"), "\xC3\xA9 ?( ? ");
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
  const std::string html = page_of(subject_of("run", ident::Grade::rejected)).html;
  EXPECT_NE(html.find("No model can be used"), std::string::npos);
  EXPECT_EQ(html.find("Recommended model"), std::string::npos);
  EXPECT_NE(html.find("The error &lt;exceeds&gt; its &quot;limit&quot; &amp; more."), std::string::npos);
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
  EXPECT_NE(page_of(subject).html.find("dead band 0.303 V instead of 0.151 V"), std::string::npos);
}

TEST(Page, ShowsTheRemarksOnItsRecord) {
  Subject subject = subject_of("run", ident::Grade::rejected);
  subject.models[0].model.provenance["remarks"] = "the output stays at 75\nsecond";
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("<li>the output stays at 75</li>"), std::string::npos);
  EXPECT_NE(html.find("<li>second</li>"), std::string::npos);
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
std::string page_with_nulls(double by_sheet_V) {
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
  (*subject.manifest)["rig"]["following"] = {{"null_V", by_sheet_V}, {"null_uncertainty_V", 0.008}};
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
                                             {"gain_uncertainty_percent", 1.0}};
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("The valve has changed since its sheet, or is another one: dead band."), std::string::npos);
  EXPECT_NE(html.find("they differ by 0.059"), std::string::npos);
  EXPECT_EQ(html.find("Trust the valve sheet"), std::string::npos);
  EXPECT_NE(html.find("mm/(V s) there, they agree"), std::string::npos);
}

TEST(Page, AdvisesNothingThatItsModelsAlreadyHave) {
  Subject subject = subject_of("run", ident::Grade::usable);
  subject.models[0].model.verdict->criteria.push_back(
      {.kind = ident::CriterionKind::residual_input, .value = 1e-6, .limit = 0.01});
  const std::string alone = page_of(subject).html;
  EXPECT_NE(alone.find("Try --input-map valve or more poles or --delay free."), std::string::npos) << alone;
  ident::Model other = model_named("io3_valve", ident::Grade::usable, 99.0);
  other.input_map = ident::ValveMap{.null = 0.0, .dead_band = 0.1, .negative_gain_ratio = 1.0};
  other.transfer_function.denominator.push_back({0.001, 3.0});
  subject.models.push_back({other, "models/io3_valve.json"});
  const std::string two = page_of(subject).html;
  EXPECT_NE(two.find("Try --delay free."), std::string::npos);
  EXPECT_EQ(two.find("Try --input-map"), std::string::npos);
  subject.models[1].model.transfer_function.delay_s = 0.002;
  EXPECT_NE(page_of(subject).html.find("are among the models already"), std::string::npos);
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
  EXPECT_NE(html.find("by standard errors that take the structure for the plant&#39;s"), std::string::npos);
  EXPECT_NE(html.find("its file lies in models/rejected"), std::string::npos);
  EXPECT_NE(html.find("<span class=\"fraction\">"), std::string::npos);
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

TEST(InUnit, ShowsTheOutputInMillimetres) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.response = record::NumberTable{{"frequency_Hz", "gain", "gain_dB", "io_gain_std_dB", "noise_dB"},
                                         {{1.0}, {0.5}, {-6.0}, {0.1}, {-40.0}}};
  const double measured = subject.fit.measured[7];
  const Subject shown = in_unit(subject, DisplayUnit("mm"));
  EXPECT_EQ(shown.fit.output.unit, "mm");
  EXPECT_DOUBLE_EQ(shown.fit.measured[7], 25.4 * measured);
  EXPECT_DOUBLE_EQ(shown.models[0].model.transfer_function.numerator[0].coefficient, 25.4 * 0.13);
  EXPECT_DOUBLE_EQ(shown.response->columns[1][0], 25.4 * 0.5);
  EXPECT_NEAR(shown.response->columns[2][0], -6.0 + 28.0967, 1e-3);
  EXPECT_DOUBLE_EQ(shown.response->columns[3][0], 0.1);
  EXPECT_DOUBLE_EQ(shown.response->columns[4][0], -40.0);
  const std::string html = page_of(shown).html;
  EXPECT_NE(html.find("displacement [mm]"), std::string::npos);
  EXPECT_EQ(html.find(" in<"), std::string::npos);
}

TEST(ComparisonPage, SaysWhatChangedAndDrawsIt) {
  const ident::Model before = model_named("io_valve", ident::Grade::good, 99.0);
  ident::PlantChange change;
  change.parameters = {{.name = "dead_band",
                        .role = ident::ParameterRole::dead_band,
                        .before = 0.15,
                        .after = 0.22,
                        .std = 0.001,
                        .half_width = 0.004,
                        .changed = true},
                       {.name = "a2", .before = 0.0132, .after = 0.0133, .std = 0.001, .half_width = 0.003}};
  change.changed = true;
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(50, 0.0, 2.0);
  const Eigen::VectorXd measured = time_s.array().sin();
  const Eigen::VectorXd simulated = 0.99 * measured;
  const Page page = comparison_page(
      {.title = "Comparison", .heading = "The plant has changed", .sentences = {"dead_band moved by 0.07 V"}},
      {{.label = "runs/<before>", .model = before, .time_s = time_s, .measured = measured, .simulated = simulated},
       {.label = "runs/after",
        .model = before,
        .change = change,
        .time_s = time_s,
        .measured = measured,
        .simulated = simulated}});
  EXPECT_TRUE(page.missing.empty());
  EXPECT_NE(page.html.find("The plant has changed"), std::string::npos);
  EXPECT_NE(page.html.find("1 of 2 parameters changed."), std::string::npos);
  EXPECT_NE(page.html.find(">0.22</td>"), std::string::npos);
  EXPECT_NE(page.html.find("runs/&lt;before&gt;"), std::string::npos);
  // Changes, step, records over time, Bode plot; these models have no valve.
  EXPECT_EQ(count(page.html, "<svg"), 4U);
  EXPECT_EQ(count(page.html, "<dt>How it should look</dt>"), 4U);
}

TEST(ComparisonPage, SaysThatOnlyTheNoiseGrewAndThatALeakMovesANull) {
  const ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  ident::PlantChange change;
  change.parameters = {{.name = "null", .role = ident::ParameterRole::valve_null, .half_width = 0.01}};
  ComparedSubject noisy{.label = "noisy",
                        .model = model,
                        .change = change,
                        .left_over = {.before = 0.00078, .after = 0.00189, .changed = true}};
  const auto page = [&](const ComparedSubject& subject) {
    return comparison_page({.title = "Comparison", .heading = "x"}, {{.label = "base", .model = model}, subject}).html;
  };
  const std::string grown = page(noisy);
  EXPECT_NE(
      grown.find("What the model leaves over changed by a factor of 2.4, from 0.00078 in rms on base to 0.00189 in."),
      std::string::npos);
  EXPECT_NE(grown.find(">left over, rms</td>"), std::string::npos);
  EXPECT_EQ(grown.find("Nothing: models of the first record still hold"), std::string::npos);
  noisy.left_over.changed = false;
  EXPECT_NE(page(noisy).find("Nothing: models of the first record still hold"), std::string::npos);
  noisy.change->changed = noisy.change->parameters[0].changed = true;
  EXPECT_NE(page(noisy).find("or comes from a leak past the piston"), std::string::npos);
}

TEST(ComparisonPage, CallsNoBandGreyThatItDoesNotKnow) {
  ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  const auto html = [&] {
    return comparison_page({.title = "Comparison", .heading = "x"},
                           {{.label = "base", .model = model}, {.label = "other", .model = model}})
        .html;
  };
  EXPECT_EQ(html().find("Grey: the usable band"), std::string::npos);
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_NE(html().find("Grey: the usable band of base."), std::string::npos);
}

TEST(ComparisonPage, DrawsBothValvesOverOneAnother) {
  ident::Model before = model_named("io_valve", ident::Grade::good, 99.0);
  before.input_map = ident::ValveMap{-0.2, 0.15, 0.88};
  ident::Model after = before;
  after.input_map->dead_band = 0.21;
  const std::string html = comparison_page({.title = "Comparison", .heading = "Changed"},
                                           {{.label = "monday", .model = before}, {.label = "friday", .model = after}})
                               .html;
  EXPECT_NE(html.find("monday passes nothing from -0.35 to -0.05 V"), std::string::npos);
  EXPECT_NE(html.find("friday passes nothing from -0.41 to 0.01 V"), std::string::npos);
  EXPECT_NE(html.find("valve of monday"), std::string::npos) << "in the key of the plot";
  EXPECT_NE(html.find("valve of friday"), std::string::npos);
}

TEST(ComparisonPage, HasTitlesThatTellRunsAndModelsApart) {
  const TemporaryFolder folder;
  for (const char* run : {"monday-paper", "friday-paper"}) {
    std::filesystem::create_directories(folder.path() / run / "models");
    std::ofstream(folder.path() / run / "models" / "io.json") << "{}";
  }
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  std::filesystem::create_directory_symlink("friday-paper", folder.path() / "latest");
  EXPECT_EQ(titles_of({path("monday-paper"), path("latest")}),
            (std::vector<std::string>{"monday-paper", "friday-paper"}));
  EXPECT_EQ(titles_of({path("monday-paper/models/io.json"), path("friday-paper/models/io.json")}),
            (std::vector<std::string>{"monday-paper/io", "friday-paper/io"}));
  EXPECT_EQ(titles_of({path("monday-paper/models/io.json")}), (std::vector<std::string>{"io"}));
}

TEST(ComparisonPage, SaysWhatHidesAChange) {
  const ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  ident::PlantChange change;
  change.parameters = {{.name = "dead_band",
                        .role = ident::ParameterRole::dead_band,
                        .before = 0.15,
                        .after = 0.9,
                        .half_width = 0.004,
                        .of_noise = 0.004,
                        .changed = true},
                       {.name = "K",
                        .role = ident::ParameterRole::numerator_coefficient,
                        .before = 0.148,
                        .after = 0.152,
                        .half_width = 0.009,
                        .of_noise = 0.001,
                        .follows = {"dead_band"}}};
  change.changed = true;
  const std::string html =
      comparison_page({.title = "Comparison", .heading = "Changed"},
                      {{.label = "monday", .model = model}, {.label = "friday", .model = model, .change = change}})
          .html;
  EXPECT_NE(html.find(">not shown</td>"), std::string::npos);
  EXPECT_NE(
      html.find("A change of K below 0.009 in/(V s) does not show here: dead_band changed, and the fit lets K follow "
                "it (by noise alone 0.001 in/(V s))."),
      std::string::npos)
      << html.substr(html.find("Seen here"), 600);
  EXPECT_NE(html.find("↑ 188"), std::string::npos) << "the bar of the dead band lies beyond the panel";
}

TEST(StepFigure, GivesTheSpeedOfAnIntegratorAndTheTimeOfItsLag) {
  ident::Model model = model_named("integrator_lag", ident::Grade::good, 99.0);
  // K/(s (T s + 1)) with K = 0.15 in/(V s), T = 0.1 s, usable from 0.05 to 5 Hz.
  model.transfer_function = {{{0.15, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}}, 0.0};
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 5.0};
  EXPECT_EQ(step_sentence(model),
            "1 V at the input moves the output at 0.15 in/s with integrator_lag; 63 % of that after 0.099 s.");
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_NE(step_sentence(model).find("63 % of that within 0.24 s, the grey part; how fast there is not observed"),
            std::string::npos)
      << step_sentence(model);
  // Where the band shows no lag, the axis reaches from its fast end to its slow one.
  EXPECT_NEAR(step_figure({&model}, "a step").panels[0].x_range->second, 1.0 / (2.0 * 3.14159265 * 0.05), 1e-6);
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 5.0};
  const plot::Figure figure = step_figure({&model}, "a step");
  ASSERT_EQ(figure.panels.size(), 2U);
  const plot::Series& speed = figure.panels[1].series.front();
  const double at_s = speed.x[speed.x.size() / 2];
  EXPECT_NEAR(speed.y[speed.y.size() / 2], 0.15 * (1.0 - std::exp(-at_s / 0.1)), 1e-4);
  ASSERT_EQ(figure.panels[0].shades.size(), 1U);
  EXPECT_NEAR(figure.panels[0].shades.front().to, 1.0 / (2.0 * 3.14159265 * 5.0), 1e-6);
}

TEST(StepFigure, DrawsAModelThatIsNotStable) {
  ident::Model model = model_named("io", ident::Grade::rejected, 50.0);
  model.transfer_function = {{{0.15, 0.0}}, {{-0.1, 2.0}, {1.0, 1.0}}, 0.0};
  const plot::Figure figure = step_figure({&model}, "a step");
  EXPECT_TRUE(std::isfinite(figure.panels[0].series.front().y.back()));
}

TEST(PoleFigure, SaysFrequencyAndDampingBesideAPairAndTheTimeConstantBesideARealPole) {
  ident::Model model = model_named("io3", ident::Grade::good, 99.0);
  // (s^2 + 2 D w s + w^2)(T s + 1), w = 2 pi 4 Hz, D = 0.3, T = 0.5 s.
  const double w = 8.0 * 3.14159265358979;
  const double T = 0.5;
  model.transfer_function = {
      {{w * w, 0.0}}, {{T, 3.0}, {1.0 + 0.6 * w * T, 2.0}, {0.6 * w + T * w * w, 1.0}, {w * w, 0.0}}, 0.0};
  std::string captions;
  const plot::Figure figure = pole_figure(model);
  for (const plot::Caption& caption : figure.panels[0].captions) captions += caption.text + "; ";
  EXPECT_NE(captions.find("4 Hz, D = 0.3; "), std::string::npos) << captions;
  EXPECT_NE(captions.find("T = 0.5 s; "), std::string::npos) << captions;
  EXPECT_NE(captions.find("10 Hz; "), std::string::npos) << "a circle: " << captions;
}

TEST(BodeFigure, DrawsBoundsOnlyWhereTheRecordShowsTheResponse) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.01, 0.05, 0.2, 0.6, 2.0};
  reported.model.bode = ident::bode_curve(reported.model, f, {});
  reported.model.bode->gain_std_dB = reported.model.bode->phase_std_deg = std::vector<double>(f.size(), 0.1);
  const auto bounds = [&] { return bode_figure({&reported}, nullptr, "Bode plot").panels[0].series.front(); };
  ASSERT_EQ(bounds().mark, plot::Mark::band);
  EXPECT_EQ(bounds().x, f) << "of a model without a band";
  reported.model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_EQ(bounds().x, (std::vector<double>{0.05, 0.2, 0.6}));
}

TEST(BodeFigure, ShowsTheErrorOfTheGainOnAScaleOfItsOwn) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.05, 0.2, 0.6};
  const ident::BodeCurve curve = ident::bode_curve(reported.model, f, {});
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "std"};
  response.columns = {f, {}, {}, curve.phase_deg, {}};
  for (const double dB : curve.gain_dB) {
    response.columns[2].push_back(dB + 0.1);
    response.columns[1].push_back(std::pow(10.0, (dB + 0.1) / 20.0));
    response.columns[4].push_back(0.002 * response.columns[1].back());
  }
  const plot::Figure figure = bode_figure({&reported}, &response, "Bode plot");
  ASSERT_EQ(figure.panels.size(), 3U);
  const plot::Series& bars = figure.panels[1].series.front();
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(bars.y[i], 0.1, 1e-9);
    EXPECT_NEAR(bars.upper[i] - bars.lower[i], 2.0 * 1.96 * 0.002 * 8.686, 1e-3);
  }
  ASSERT_TRUE(figure.panels[1].y_range.has_value());
  EXPECT_LT(figure.panels[1].y_range->second - figure.panels[1].y_range->first, 0.3) << "the bars can be seen";
  EXPECT_LT(figure.panels[1].y_range->first, 0.0) << "and how far they are from 0";
}

TEST(FitTableFigure, ShowsTheTwoModelsOfLeastErrorAndSaysSo) {
  Subject subject = subject_of("run", ident::Grade::good);
  for (const auto& [name, error] : {std::pair("far", 0.5), std::pair("near", 0.001), std::pair("lost", std::nan(""))}) {
    subject.fit.models.push_back({name, subject.fit.measured});
    for (double& y : subject.fit.models.back().simulated) y += error;
  }
  const plot::Figure figure = fit_table_figure(subject.fit, "fit.csv");
  EXPECT_EQ(figure.title, "fit.csv: the 2 of 4 models with the least error");
  ASSERT_EQ(figure.panels[0].series.size(), 3U);
  EXPECT_EQ(figure.panels[0].series[1].label, "near");
  EXPECT_EQ(figure.panels[0].series[2].label, "io");
}

TEST(LoadModels, TakesTheTableOfTheirFolder) {
  const TemporaryFolder folder;
  const auto file = folder.write("io.json", ident::to_text(model_named("io", ident::Grade::good, 99.0)));
  folder.write("fit.csv",
               "time_s,voltage_V,displacement_in,io_in,io_residual_in,fo_in,fo_residual_in\n"
               "0,1,2,2.5,-0.5,2,0\n0.1,1,2,2.5,-0.5,2,0\n");
  const Subject subject = load_models({file});
  ASSERT_EQ(subject.fit.models.size(), 1U);
  EXPECT_EQ(subject.fit.models[0].simulated[1], 2.5);
}

TEST(LoadModels, PutsTheBestModelFirst) {
  const TemporaryFolder folder;
  const auto bad = folder.write("a.json", ident::to_text(model_named("a", ident::Grade::rejected, 99.9)));
  const auto usable = folder.write("b.json", ident::to_text(model_named("b", ident::Grade::usable, 95.0)));
  const auto better = folder.write("c.json", ident::to_text(model_named("c", ident::Grade::usable, 97.0)));
  const Subject subject = load_models({bad, usable, better});
  EXPECT_EQ(subject.models[0].model.name, "c");
  EXPECT_EQ(subject.models[2].model.name, "a");
}

TEST(LoadRun, RefusesAFolderThatIsNone) {
  const TemporaryFolder folder;
  EXPECT_THROW(static_cast<void>(load_run(folder.path())), DataError);
}

}  // namespace
}  // namespace eha::report
