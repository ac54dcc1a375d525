// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison pages and the figures of reports.
#include "daemon/report/figures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/report/comparison_page.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/html.hpp"
#include "ident/model/model_file.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

TEST(RecordFigure, SaysWhatWasNotMeasured) {
  ident::Record record;
  record.step_s = 0.1;
  record.input = Eigen::VectorXd::Zero(1000);
  record.output = Eigen::VectorXd::LinSpaced(1000, 0.0, 1.0);
  record.unmeasured = {3};
  EXPECT_TRUE(record_figure(record, "").panels[0].shades.empty()) << "a row is no gap";
  EXPECT_EQ(record_figure(record, "").panels[0].series[0].label, "measured output");
  for (std::size_t k = 500; k < 600; ++k) record.unmeasured.push_back(k);
  const plot::Figure figure = record_figure(record, "");
  ASSERT_EQ(figure.panels[0].shades.size(), 1U);
  EXPECT_NEAR(figure.panels[0].shades[0].from, 50.0, 1e-9);
  EXPECT_NEAR(figure.panels[0].shades[0].to, 60.0, 1e-9);
  EXPECT_EQ(figure.panels[0].series[0].label, "output, 10 % of its rows not measured and interpolated");
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
  EXPECT_LT(page.html.find("To do: Look on the bench for what changed."), page.html.find("<svg")) << "in the box";
  EXPECT_NE(page.html.find(">0.2200</td>"), std::string::npos);
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
  EXPECT_EQ(grown.find("<dd>Nothing"), std::string::npos);
  noisy.left_over.changed = false;
  EXPECT_NE(page(noisy).find("Nothing: no change of a parameter is shown"), std::string::npos);
  noisy.left_over.after = 0.02;
  noisy.first_model_error = 0.021;
  EXPECT_NE(page(noisy).find("Nothing: the model of the first record holds on this one"), std::string::npos);
  noisy.first_model_error = 0.12;
  noisy.first_model_holds = false;
  const std::string other = page(noisy);
  EXPECT_NE(other.find("The model of base errs by 0.12 in rms on noisy, 6 times the 0.02 in of the model fitted there: "
                       "it does not hold."),
            std::string::npos)
      << other;
  EXPECT_NE(other.find(">of the first model, rms</td>"), std::string::npos);
  EXPECT_NE(other.find(">does not hold</td>"), std::string::npos) << "the table says the same";
  EXPECT_EQ(count(other, "Friction, a leak or the load may have changed"), 1U) << other;
  EXPECT_LT(other.find("To do: Friction, a leak or the load may have changed"), other.find("<svg")) << "in the box";
  EXPECT_NE(other.find("<dd>As the box above says.</dd>"), std::string::npos) << other;
  noisy.is_tight = true;
  noisy.change->parameters[0].after = 0.008;
  EXPECT_NE(
      page(noisy).find("To do: Nearest to a change is null, by 0.008 V, 80 % of what would show. By the valve "
                       "sheets the rods creep too slowly for a leak, so that dry friction or the load is another one"),
      std::string::npos)
      << page(noisy);
  EXPECT_EQ(other.find("<dd>Nothing"), std::string::npos);
  noisy.change->changed = noisy.change->parameters[0].changed = true;
  EXPECT_NE(page(noisy).find("else dry friction or a leak past the piston"), std::string::npos);
}

TEST(ComparisonPage, SaysFirstWhatChangedInFigures) {
  ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  model.input_unit = "V";
  ident::PlantChange change;
  change.changed = true;
  change.parameters = {{.name = "K", .before = 0.148, .after = 0.149, .half_width = 0.003},
                       {.name = "null",
                        .role = ident::ParameterRole::valve_null,
                        .before = -0.2066,
                        .after = -0.3912,
                        .half_width = 0.01,
                        .changed = true},
                       {.name = "dead_band",
                        .role = ident::ParameterRole::dead_band,
                        .before = 0.1487,
                        .after = 0.3144,
                        .half_width = 0.005,
                        .changed = true}};
  ComparedSubject after{.label = "after", .model = model, .change = change, .left_over = {1.0, 3.0, true}};
  EXPECT_EQ(
      outcome({.label = "base", .model = model}, after),
      "The plant changed: half dead band 0.1487 to 0.3144 V (+0.1657 +- 0.0050 V), null -0.207 to -0.391 V (-0.185 +- "
      "0.010 V); and what the model leaves over");
  after.judges_left_over = false;
  EXPECT_TRUE(outcome({.label = "base", .model = model}, after).ends_with(" +- 0.010 V)"));
  after.map_cause = MapCause::leak;
  EXPECT_TRUE(outcome({.label = "base", .model = model}, after).starts_with("The plant changed, as by a leak: half"));
  after.change->parameters.front().changed = true;
  EXPECT_TRUE(outcome({.label = "base", .model = model}, after).starts_with("The plant changed: half"))
      << "a leak changes no gain";
  ComparedSubject third = after;
  third.label = "third";
  const ComparedSubject alike{.label = "fourth", .model = model};
  const std::string all = outcome_of_all({{.label = "base", .model = model}, after, third, alike});
  EXPECT_EQ(all.rfind("after: The plant changed: half", 0), 0U) << all;
  EXPECT_NE(all.find("; third: The plant changed: half"), std::string::npos) << "each that changed: " << all;
  EXPECT_EQ(all.find("fourth"), std::string::npos) << all;
}

TEST(ComparisonPage, BlamesTheModelsAndNotTheRigWhereTheyAreOfOneRecord) {
  const ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  const auto html_of = [&](bool is_one_plant, bool is_alike) {
    return comparison_page({.title = "Models",
                            .heading = "x",
                            .is_alike = is_alike,
                            .is_one_plant = is_one_plant,
                            .to_do = "Use it."},
                           {{.label = "io", .model = model}, {.label = "fo", .model = model}})
        .html;
  };
  const std::string one = html_of(true, true);
  EXPECT_EQ(count(one, "the models differ, not the rig"), 2U) << "step and response";
  EXPECT_EQ(one.find("the plants differ"), std::string::npos);
  EXPECT_EQ(one.find("A lower speed is a lower gain"), std::string::npos);
  EXPECT_NE(html_of(false, true).find("the plants differ at that frequency"), std::string::npos);
  // The box looks otherwise where something is wrong.
  EXPECT_NE(one.find("<section class=\"verdict all\">"), std::string::npos);
  EXPECT_NE(html_of(true, false).find("<section class=\"verdict some\">"), std::string::npos);
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
  EXPECT_NE(html().find("Grey: the usable band of base, 0.05 to 0.65 Hz."), std::string::npos);
}

TEST(ComparisonPage, PrintsThePictureOfFourPanelsWithTextsThatCanBeRead) {
  // Of 4 panels and a long key; letters of 14 units, and a point is 0.353 mm.
  constexpr double kUnitsOfFourPanels = 960.0;
  constexpr double kLetter = 14.0;
  const ident::Model model = model_named("io", ident::Grade::good, 99.0);
  const std::string html =
      comparison_page({.title = "Comparison", .heading = "x"}, {{.label = "io", .model = model}}).html;
  const std::string key = ".plot svg { max-height: ";
  const std::size_t at = html.find(key);
  ASSERT_NE(at, std::string::npos);
  const double height_mm = std::stod(html.substr(at + key.size()));
  EXPECT_GE(kLetter * height_mm / kUnitsOfFourPanels / 0.353, 6.5);
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
  EXPECT_EQ(html.find("<text>-4000</text>"), std::string::npos);
  const std::string wide =
      comparison_page({.title = "Comparison", .heading = "Changed"},
                      {{.label = "monday", .model = before, .input_range = std::pair(-5000.0, 5000.0)},
                       {.label = "friday", .model = after, .input_range = std::pair(-4000.0, 4000.0)}})
          .html;
  EXPECT_NE(wide.find("<text>-4000</text>"), std::string::npos) << "over the range of the inputs";
  EXPECT_NE(wide.find("<text>-0.4</text>"), wide.rfind("<text>-0.4</text>"))
      << "and about the null, where a dead band is seen, on both axes";
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
                "it (by noise alone 0.001 in/(V s)); each fit by itself says "),
      std::string::npos)
      << html.substr(html.find("Seen here"), 600);
  EXPECT_NE(html.find("↑ 188"), std::string::npos) << "the bar of the dead band lies beyond the panel";
  EXPECT_NE(html.find("1 of 2 parameters changed."), std::string::npos);
  // Where the records cannot tell, no part of the page says that something changed.
  const std::string unknown =
      comparison_page({.title = "Comparison", .heading = "Not shown"},
                      {{.label = "monday", .model = model},
                       {.label = "friday", .model = model, .change = change, .cannot_tell = "the inputs differ"}})
          .html;
  EXPECT_NE(
      unknown.find("1 of 2 parameters differ, which is not shown to be a change of the plant: the inputs differ."),
      std::string::npos);
  EXPECT_NE(unknown.find(">differs</td>"), std::string::npos);
  EXPECT_EQ(unknown.find(">yes</td>"), std::string::npos);
  EXPECT_EQ(unknown.find("Look on the bench for what changed"), std::string::npos);
}

TEST(StepFigure, GivesTheSpeedOfAnIntegratorAndTheTimeOfItsLag) {
  ident::Model model = model_named("integrator_lag", ident::Grade::good, 99.0);
  // K/(s (T s + 1)) with K = 0.15 in/(V s), T = 0.1 s, usable from 0.05 to 5 Hz.
  model.transfer_function = {{{0.15, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}}, 0.0};
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 5.0};
  EXPECT_EQ(step_sentence(model),
            "1 V at the input moves the output at 0.15 in/s with integrator_lag; 63 % of that after 0.1 s.");
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_NE(
      step_sentence(model).find("63 % of that after 0.1 s by the model, in the hatched part of 0.24 s: it is faster"),
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
  EXPECT_EQ(figure.panels[0].shades.front().look, plot::Look::hatched) << "not as the usable band of a Bode plot";
  EXPECT_NE(figure.panels[0].shades.front().label, "");
  EXPECT_NEAR(figure.panels[0].shades.front().to, 1.0 / (2.0 * 3.14159265 * 5.0), 1e-6);
}

TEST(StepFigure, ShowsALagThatIsShortAgainstTheAxis) {
  ident::Model model = model_named("integrator_lag", ident::Grade::good, 99.0);
  model.transfer_function = {{{0.15, 0.0}}, {{0.006, 2.0}, {1.0, 1.0}}, 0.0};
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_NE(step_sentence(model).find("63 % of that after 0.006 s by the model"), std::string::npos)
      << step_sentence(model);
  model.transfer_function.denominator.front().coefficient = 0.0067448;
  EXPECT_NE(step_sentence(model).find("63 % of that after 0.0067 s by the model"), std::string::npos)
      << step_sentence(model);
  model.transfer_function.denominator.front().coefficient = 0.006;
  const plot::Series speed = step_figure({&model}, "a step").panels[1].series.front();
  EXPECT_TRUE(std::is_sorted(speed.x.begin(), speed.x.end()));
  const auto rising = std::count_if(speed.y.begin(), speed.y.end(), [](double v) { return v > 0.015 && v < 0.12; });
  EXPECT_GT(rising, 20) << "the rise is drawn as it is";
  EXPECT_NEAR(speed.y.back(), 0.15, 1e-6);
}

TEST(StepFigure, SaysWhereARingingOutputComesToRest) {
  ident::Model model = model_named("io", ident::Grade::good, 99.0);
  // K = 12, 2 Hz, D = 0.02.
  const double w = 2.0 * 3.14159265358979 * 2.0;
  model.transfer_function = {{{12.0, 0.0}}, {{1.0 / (w * w), 2.0}, {0.04 / w, 1.0}, {1.0, 0.0}}, 0.0};
  EXPECT_NE(step_sentence(model).find("brings the output to 12 in"), std::string::npos) << step_sentence(model);
}

TEST(StepFigure, SaysOfALightlyDampedPairThatItOvershootsAndNotThatItMovesOn) {
  // K = 1.5, 1.3 Hz; the usable band is as of a record of tones to 2.95 Hz.
  const double w = 2.0 * 3.14159265358979 * 1.3;
  for (const double damping : {0.003, 0.01, 0.03, 0.2}) {
    ident::Model model = model_named("io", ident::Grade::good, 99.0);
    model.transfer_function = {{{1.5, 0.0}}, {{1.0 / (w * w), 2.0}, {2.0 * damping / w, 1.0}, {1.0, 0.0}}, 0.0};
    model.verdict->usable_band = ident::FrequencyInterval{0.0525, 2.95};
    const std::string text = step_sentence(model);
    EXPECT_NE(text.find("brings the output to 1.5 in with io"), std::string::npos) << damping << ": " << text;
    const double overshoot = 100.0 * std::exp(-3.14159265358979 * damping / std::sqrt(1.0 - damping * damping));
    EXPECT_NE(text.find(fmt::format("it overshoots by {:.2g} %, f0 = 1.3 Hz.", overshoot)), std::string::npos)
        << damping << ": " << text;
    EXPECT_EQ(text.find("hatched part"), std::string::npos) << text;
    if (damping < 0.02) {
      EXPECT_TRUE(step_figure({&model}, "a step").panels[0].shades.empty()) << "too short to be seen";
    }
  }
}

TEST(StepFigure, GivesTheValueAtRestOfALagAndNotThatAtTheEndOfThePicture) {
  ident::Model model = model_named("io1", ident::Grade::good, 99.0);
  model.transfer_function = {{{2.5, 0.0}}, {{0.3, 1.0}, {1.0, 0.0}}, 0.2};
  model.verdict->usable_band = ident::FrequencyInterval{0.02, 5.0};
  const std::string text = step_sentence(model);
  EXPECT_NE(text.find("brings the output to 2.5 in with io1; 63 % of that after 0.5 s."), std::string::npos) << text;
  EXPECT_EQ(text.find("overshoots"), std::string::npos) << text;
}

TEST(ValvePanel, DrawsTheGuideWithTheRatioOfTheGains) {
  ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  model.input_map = ident::ValveMap{.null = 0.1, .dead_band = 0.2, .negative_gain_ratio = 0.5};
  const plot::Series guide = valve_panel({&model}, -0.9, 1.1).series.front();
  ASSERT_EQ(guide.y.size(), 3U);
  EXPECT_NEAR(guide.y[0], -0.5, 1e-12);
  EXPECT_NEAR(guide.y[1], 0.0, 1e-12);
  EXPECT_NEAR(guide.y[2], 1.0, 1e-12);
}

TEST(BodeFigure, DrawsThePeakOfAResonanceBetweenTheStoredPoints) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const double w = 2.0 * 3.14159265358979 * 2.0;
  reported.model.transfer_function = {{{12.0, 0.0}}, {{1.0 / (w * w), 2.0}, {0.04 / w, 1.0}, {1.0, 0.0}}, 0.0};
  const std::vector<double> stored_Hz{0.1, 0.5, 1.5, 2.7, 10.0};
  reported.model.bode = ident::bode_curve(reported.model, stored_Hz, {});
  const plot::Series gain = bode_figure({&reported}, nullptr, "Bode plot").panels[0].series.front();
  EXPECT_NEAR(*std::max_element(gain.y.begin(), gain.y.end()), 20.0 * std::log10(12.0 / 0.04), 0.1);
  EXPECT_NEAR(gain.x.front(), 0.1, 1e-9);
  EXPECT_NEAR(gain.x.back(), 10.0, 1e-9);
}

TEST(StepFigure, SaysThatAnIntegratorHasNoLag) {
  ident::Model model = model_named("integrator_lag", ident::Grade::good, 99.0);
  model.transfer_function = {{{0.15, 0.0}}, {{1.0, 1.0}, {0.0, 0.0}}, 0.0};
  model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  EXPECT_EQ(step_sentence(model),
            "1 V at the input moves the output at 0.15 in/s with integrator_lag, at once: the model has no lag.");
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

TEST(PoleFigure, DrawsAnIntegratorsRoundedPoleAtZero) {
  ident::Model model = model_named("io", ident::Grade::good, 99.0);
  model.transfer_function = {{{0.2, 0.0}}, {{0.05, 2.0}, {1.0, 1.0}, {4e-13, 0.0}}, 0.0};
  const plot::Panel panel = pole_figure(model).panels[0];
  EXPECT_EQ(panel.series.back().label, "pole at 0");
  for (const plot::Caption& caption : panel.captions) {
    EXPECT_EQ(caption.text.find("e-"), std::string::npos) << caption.text;
  }
}

TEST(PoleFigure, KeepsCaptionsApart) {
  // Real poles close to one another: their captions are wider than their distance.
  ident::Model model = model_named("io", ident::Grade::good, 99.0);
  model.transfer_function = {{{1.0, 0.0}}, {{0.02 * 0.05, 2.0}, {0.07, 1.0}, {1.0, 0.0}}, 0.0};
  const std::vector<plot::Caption> captions = pole_figure(model).panels[0].captions;
  constexpr double kLetter = 0.055;  // of the drawn picture
  constexpr double kLine = 0.12;
  for (const plot::Caption& a : captions) {
    for (const plot::Caption& b : captions) {
      if (&a == &b || std::abs(a.y - b.y) >= kLine) continue;
      EXPECT_GE(std::abs(a.x - b.x), 0.5 * kLetter * static_cast<double>(a.text.size() + b.text.size()))
          << a.text << " and " << b.text;
    }
  }
}

TEST(BodeFigure, DrawsALineBeyondTheUsableBandFaintAndSaysSo) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const auto lines = [&](bool is_faint) {
    std::vector<plot::Series> found;
    const plot::Figure figure = bode_figure({&reported}, nullptr, "Bode plot");
    for (const plot::Panel& panel : figure.panels) {
      for (const plot::Series& series : panel.series) {
        if (series.mark == plot::Mark::line && series.is_faint == is_faint) found.push_back(series);
      }
    }
    return found;
  };
  const auto ends = [](const plot::Series& series) {
    std::vector<double> x;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (std::isfinite(series.y[i])) x.push_back(series.x[i]);
    }
    return std::pair(x.front(), x.back());
  };
  reported.model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  ASSERT_EQ(lines(false).size(), 2U) << "gain and phase";
  ASSERT_EQ(lines(true).size(), 2U);
  EXPECT_EQ(lines(false)[0].label, "io");
  EXPECT_GE(ends(lines(false)[0]).first, 0.05 * 0.999);
  EXPECT_LE(ends(lines(false)[0]).second, 0.65 * 1.001);
  EXPECT_LT(ends(lines(true)[0]).first, 0.05);
  EXPECT_GT(ends(lines(true)[0]).second, 1.0);
  EXPECT_EQ(lines(true)[0].label, "outside the usable band");
  const plot::Figure figure = bode_figure({&reported}, nullptr, "Bode plot");
  ASSERT_EQ(figure.panels[0].shades.size(), 1U);
  EXPECT_EQ(figure.panels[0].shades[0].label, "usable band");
  reported.model.verdict->usable_band.reset();
  EXPECT_TRUE(lines(false).empty()) << "nothing is usable";
  EXPECT_EQ(lines(true)[0].label, "io, no usable band");
  reported.model.verdict.reset();
  EXPECT_TRUE(lines(true).empty()) << "nothing is known of either";
}

TEST(CorrelationPanel, HoldsTheStemOfLag0) {
  ident::Correlation correlation;
  correlation.lags = {0, 1, 2};
  correlation.values = {1.0, 0.3, -0.2};
  correlation.bound95 = 0.1;
  correlation.bound99 = 0.13;
  const plot::Panel panel = correlation_panel(correlation, "ACF");
  ASSERT_TRUE(panel.y_range);
  EXPECT_GE(panel.y_range->second, 1.0);
}

TEST(ChangesFigure, DrawsNoBarOfAChangeBeyondItsAxis) {
  const ident::Model model = model_named("io", ident::Grade::good, 99.0);
  ident::PlantChange change;
  change.parameters = {{.name = "far", .before = 0.0, .after = -12.0, .std = 0.5, .half_width = 1.0, .changed = true},
                       {.name = "near", .before = 0.0, .after = 0.5, .std = 0.5, .half_width = 1.0}};
  change.changed = true;
  const std::string html =
      comparison_page({.title = "Comparison", .heading = "x"},
                      {{.label = "base", .model = model}, {.label = "other", .model = model, .change = change}})
          .html;
  EXPECT_NE(html.find("↓ -12"), std::string::npos);
  EXPECT_NE(html.find("A value beyond 10 is an arrow with its number, without a bar."), std::string::npos);
}

TEST(BodeFigure, DrawsBoundsOnlyWhereTheRecordShowsTheResponse) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.01, 0.05, 0.2, 0.6, 2.0};
  reported.model.bode = ident::bode_curve(reported.model, f, {});
  reported.model.bode->gain_std_dB = reported.model.bode->phase_std_deg = std::vector<double>(f.size(), 0.1);
  const auto bounds = [&] { return bode_figure({&reported}, nullptr, "Bode plot").panels[0].series.front(); };
  ASSERT_EQ(bounds().mark, plot::Mark::band);
  EXPECT_NEAR(bounds().x.front(), f.front(), 1e-9) << "of a model without a band";
  EXPECT_NEAR(bounds().x.back(), f.back(), 1e-9);
  reported.model.verdict->usable_band = ident::FrequencyInterval{0.05, 0.65};
  constexpr double kGrid = 1.04;  // of neighbours
  EXPECT_GE(bounds().x.front(), 0.05);
  EXPECT_LT(bounds().x.front(), 0.05 * kGrid);
  EXPECT_LE(bounds().x.back(), 0.65);
  EXPECT_GT(bounds().x.back(), 0.65 / kGrid);
}

TEST(BodeFigure, SaysOfBoundsThatTheLineHidesThatItDoes) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.01, 0.05, 0.2, 0.6, 2.0};
  reported.model.bode = ident::bode_curve(reported.model, f, {});
  const auto label_for = [&](double std_dB) {
    reported.model.bode->gain_std_dB = reported.model.bode->phase_std_deg = std::vector<double>(f.size(), std_dB);
    return bode_figure({&reported}, nullptr, "Bode plot").panels[0].series.front().label;
  };
  EXPECT_EQ(label_for(3.0), "95 % bounds");
  EXPECT_EQ(label_for(0.001), "95 % bounds, narrower than the line");
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

TEST(BodeFigure, ComparesAModelBehindAMapWithItsMap) {
  ReportedModel reported{model_named("io_valve", ident::Grade::good, 99.0), "io_valve.json"};
  const ident::ValveMap map{-0.2, 0.3, 0.9};
  reported.model.input_map = map;
  const std::vector<double> f{0.05, 0.2};
  identify::FitTable fit;
  constexpr int kRows = 1000;
  Eigen::VectorXd volts(kRows);
  for (int k = 0; k < kRows; ++k) {
    fit.time_s.push_back(0.04 * k);
    const double t = 2.0 * std::numbers::pi * fit.time_s.back();
    volts[k] = 1.5 * std::cos(f[0] * t) + 1.0 * std::cos(f[1] * t + 1.0);
    fit.applied.push_back(volts[k]);
  }
  // The plant is the model: its response is that of G to what the valve passes.
  const Eigen::VectorXd passed = mapped(map, volts);
  const ident::BodeCurve of_g = ident::bode_curve(reported.model, f, {});
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "std"};
  response.columns = {f, {}, {}, {}, {}};
  for (std::size_t i = 0; i < f.size(); ++i) {
    std::complex<double> in;
    std::complex<double> out;
    for (int k = 0; k < kRows; ++k) {  // 40 s, whole periods of both
      const auto turn = std::polar(1.0, -2.0 * std::numbers::pi * f[i] * fit.time_s[static_cast<std::size_t>(k)]);
      in += volts[k] * turn;
      out += passed[k] * turn;
    }
    response.columns[2].push_back(of_g.gain_dB[i] + 20.0 * std::log10(std::abs(out / in)));
    response.columns[3].push_back(of_g.phase_deg[i] + std::arg(out / in) * kDegrees);
    response.columns[1].push_back(std::pow(10.0, response.columns[2].back() / 20.0));
    response.columns[4].push_back(0.001 * response.columns[1].back());
  }
  const plot::Figure figure = bode_figure({&reported}, &response, "Bode plot", &fit);
  const plot::Panel& gain = figure.panels[0];
  const auto with_map = std::find_if(gain.series.begin(), gain.series.end(), [](const plot::Series& series) {
    return series.label == "io_valve with its map, at the lines";
  });
  ASSERT_NE(with_map, gain.series.end());
  for (std::size_t i = 0; i < f.size(); ++i) {
    EXPECT_NEAR(with_map->y[i], response.columns[2][i], 1e-6);
    EXPECT_LT(with_map->y[i], of_g.gain_dB[i] - 1.0) << "the dead band takes its share";
    EXPECT_NEAR(figure.panels[1].series.front().y[i], 0.0, 1e-6);
  }
  EXPECT_LT(figure.panels[1].y_range->second - figure.panels[1].y_range->first, 0.1) << "the bars can be seen";
}

TEST(BodeFigure, SaysWhereNoiseLiesThatItsAxisDoesNotReach) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.05, 0.2, 0.6};
  const ident::BodeCurve curve = ident::bode_curve(reported.model, f, {});
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "std", "noise_dB"};
  response.columns = {f, {}, curve.gain_dB, curve.phase_deg, {0.001, 0.001, 0.001}, {-20.0, -200.0, -200.0}};
  for (const double dB : curve.gain_dB) response.columns[1].push_back(std::pow(10.0, dB / 20.0));
  const auto noise_of = [&] {
    const plot::Panel gain = bode_figure({&reported}, &response, "Bode plot").panels[0];
    const auto noise = std::find_if(gain.series.begin(), gain.series.end(),
                                    [](const plot::Series& series) { return series.label.starts_with("noise"); });
    return noise == gain.series.end()
               ? 0
               : std::count_if(noise->y.begin(), noise->y.end(), [](double y) { return std::isfinite(y); });
  };
  const auto key = [&] {
    const plot::Panel gain = bode_figure({&reported}, &response, "Bode plot").panels[0];
    std::string labels;
    for (const plot::Series& series : gain.series) labels += series.label + "\n";
    return labels;
  };
  EXPECT_EQ(noise_of(), 1);
  EXPECT_NE(key().find("noise (2 of 3 lines below the axis, at -2"), std::string::npos) << key();
  response.columns[5][0] = -200.0;
  EXPECT_EQ(noise_of(), 0);
  const double median_dB = *std::next(curve.gain_dB.begin()) - 200.0;
  EXPECT_NE(key().find(fmt::format("; noise at {:.0f} dB", median_dB)), std::string::npos)
      << "the measured median, not the end of the axis: " << key();
  // Noise that the axis holds is whole: no mark lies on its edge.
  response.columns[5] = {-30.0, -31.0, -32.0};
  const plot::Panel gain = bode_figure({&reported}, &response, "Bode plot").panels[0];
  for (const plot::Series& series : gain.series) {
    if (!series.label.starts_with("noise")) continue;
    EXPECT_EQ(series.label, "noise");
    for (const double y : series.y) EXPECT_GT(y, gain.y_range->first + 2.9);
  }
}

TEST(BodeFigure, ChoosesItsAxisByModelsAndMeasuredLinesNotByNoise) {
  ReportedModel reported{model_named("io", ident::Grade::good, 99.0), "io.json"};
  const std::vector<double> f{0.05, 0.2, 0.6};
  const ident::BodeCurve curve = ident::bode_curve(reported.model, f, {});
  record::NumberTable response;
  response.names = {"frequency_Hz", "gain", "gain_dB", "phase_deg", "std", "noise_dB"};
  response.columns = {f, {}, curve.gain_dB, curve.phase_deg, {1e-4, 1e-4, 1e-4}, {-90.0, -90.0, -90.0}};
  for (const double dB : curve.gain_dB) response.columns[1].push_back(std::pow(10.0, dB / 20.0));
  const auto span = [&] {
    const auto range = bode_figure({&reported}, &response, "Bode plot").panels[0].y_range;
    return range->second - range->first;
  };
  const double with_noise = span();
  response.columns[5] = std::vector<double>(3, std::numeric_limits<double>::quiet_NaN());
  EXPECT_LE(with_noise, span() + 15.0);
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

TEST(FitFigure, DrawsTheErrorsOfTwoModelsApartOnOneScale) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.fit.models.push_back({"far", subject.fit.measured});
  for (double& y : subject.fit.models.back().simulated) y -= 0.5;
  const plot::Figure figure = fit_figure(subject.fit, {"io", "far"}, subject.split_s(), "run");
  ASSERT_EQ(figure.panels.size(), 4U);
  ASSERT_EQ(figure.panels[1].series.size(), 1U) << "a dense curve hides the other one";
  EXPECT_EQ(figure.panels[1].series.front().label, "error of io");
  EXPECT_EQ(figure.panels[2].series.front().label, "error of far");
  EXPECT_EQ(figure.panels[2].series.front().style, 2) << "as its output";
  ASSERT_TRUE(figure.panels[1].y_range.has_value());
  EXPECT_EQ(figure.panels[1].y_range, figure.panels[2].y_range);
  EXPECT_GT(figure.panels[1].y_range->second, 0.5);
}

TEST(TripFigure, MarksTheTripBeyondTheLastRowOfTheFit) {
  const Subject subject = subject_of("run", ident::Grade::good);
  plot::Figure figure = fit_figure(subject.fit, {"io"}, std::nullopt, "run");
  ident::Record record;
  record.step_s = 0.01;
  record.input = record.output = Eigen::VectorXd::LinSpaced(420, 0.0, 1.0);  // 0.23 s beyond the last row of the fit
  add_rest(figure, subject.fit, record);
  EXPECT_NEAR(figure.panels.front().series.back().x.back(), 4.19, 1e-9);
  EXPECT_EQ(figure.panels.front().series.back().label, "single readings");
  EXPECT_EQ(figure.panels.back().series.back().label, "each tick");
  mark_trip(figure, 4.2);
  EXPECT_EQ(figure.panels.front().series.back().label, "trip at 4.2 s");
  for (const plot::Panel& panel : figure.panels) {
    ASSERT_TRUE(panel.x_range);
    EXPECT_GT(panel.x_range->second, 4.2);
  }
  EXPECT_DOUBLE_EQ(figure.panels[1].rules.back().at, 4.2);
}

TEST(TripFigure, SaysWhichPartIsFiltered) {
  Subject subject = subject_of("run", ident::Grade::good);
  subject.manifest.emplace();
  (*subject.manifest)["outcome"] = "faulted";
  (*subject.manifest)["report"]["fault"]["at_s"] = 4.2;
  subject.record.emplace();
  subject.record->step_s = 0.01;
  subject.record->input = subject.record->output = Eigen::VectorXd::LinSpaced(420, 0.0, 1.0);
  const std::string html = page_of(subject).html;
  EXPECT_NE(html.find("To 3.96 s the curves show the rows of the fit, filtered and one every 40 ms"),
            std::string::npos);
  (*subject.manifest)["outcome"] = "completed";
  EXPECT_EQ(page_of(subject).html.find("the rows of the fit, filtered"), std::string::npos);
}

TEST(TripFigure, DrawsTheRestNoDenserThanTheFit) {
  const Subject subject = subject_of("run", ident::Grade::good);
  plot::Figure figure = fit_figure(subject.fit, {"io"}, std::nullopt, "run");
  ident::Record record;
  record.step_s = 1e-5;
  record.input = record.output = Eigen::VectorXd::Zero(420000);  // 24 000 rows beyond the last row of the fit
  record.output.tail(2).setOnes();
  add_rest(figure, subject.fit, record);
  const plot::Series& rest = figure.panels.front().series.back();
  EXPECT_LE(rest.x.size(), 100U);
  EXPECT_NEAR(rest.x.back(), 4.2, 0.001);
  EXPECT_DOUBLE_EQ(*std::max_element(rest.y.begin(), rest.y.end()), 1.0);
}

TEST(TripFigure, MarksTheTripOfAnOutputThatStoodStill) {
  plot::Figure figure;
  figure.panels.push_back({.x_label = "", .y_label = "", .series = {{.label = "rod", .x = {0, 1}, .y = {2.95, 2.95}}}});
  mark_trip(figure, 1.0);
  const plot::Series& trip = figure.panels.front().series.back();
  EXPECT_EQ(trip.label, "trip at 1 s");
  EXPECT_LT(trip.y.front(), 2.9);
  EXPECT_GT(trip.y.back(), 3.0);
}

TEST(TripFigure, DrawsATrialUntilTheTripAsRead) {
  const identify::FitTable rows{.input = {"command", "V"},
                                .output = {"displacement", "in"},
                                .time_s = {0.0, 0.001, 0.002},
                                .applied = {0.0, 0.1, 0.2},
                                .measured = {1.0, 1.2, 1.1},
                                .models = {{"reference", {1.0, 1.1, 1.2}}}};
  const plot::Figure figure = ended_trial_figure(rows, "trial");
  ASSERT_EQ(figure.panels.size(), 3U);
  EXPECT_EQ(figure.panels[1].y_label, "error, rod - reference [in]");
  EXPECT_EQ(figure.panels[1].series.front().label, "single readings");
  ASSERT_EQ(figure.panels[1].series.front().y.size(), 3U);
  EXPECT_NEAR(figure.panels[1].series.front().y.back(), -0.1, 1e-9);
}

TEST(FitFigure, NamesTheErrorAsMeasuredLessModel) {
  const Subject subject = subject_of("run", ident::Grade::good);  // its model is 0.01 too high
  const plot::Figure figure = fit_figure(subject.fit, {"io"}, subject.split_s(), "run");
  EXPECT_EQ(figure.panels[1].y_label, "error, measured - model [in]");
  EXPECT_NEAR(figure.panels[1].series.front().y.front(), -0.01, 1e-9);
  ASSERT_TRUE(subject.split_s());
  EXPECT_NEAR(*subject.split_s(), 2.0, 1e-9) << "50 of 100 samples estimated";
}

TEST(ComparisonPage, ReadsNoChangeOfTheGainIntoPicturesWhereTheDeadBandAloneChanged) {
  ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  model.input_map = ident::ValveMap{-0.2, 0.15, 0.9};
  ident::PlantChange change;
  change.changed = true;
  change.parameters = {
      {.name = "dead_band", .role = ident::ParameterRole::dead_band, .half_width = 0.01, .changed = true},
      {.name = "K", .half_width = 0.01}};
  const auto page = [&] {
    return comparison_page({.title = "Comparison", .heading = "The plant has changed"},
                           {{.label = "base", .model = model}, {.label = "after", .model = model, .change = change}})
        .html;
  };
  EXPECT_EQ(count(page(), "Nothing: only the valve&#39;s map is shown to have changed."), 2U) << "step and response";
  EXPECT_EQ(page().find("A lower speed is a lower gain"), std::string::npos);
  EXPECT_EQ(page().find("the plants differ at that frequency"), std::string::npos);
  change.parameters[1].changed = true;
  EXPECT_NE(page().find("A lower speed is a lower gain"), std::string::npos);
}

}  // namespace
}  // namespace eha::report
