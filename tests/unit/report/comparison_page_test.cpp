// SPDX-License-Identifier: GPL-3.0-or-later
// Comparison pages and the bars of their changes.
#include "daemon/report/comparison_page.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "daemon/report/html.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

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
  EXPECT_NE(page(noisy).find("To do: Nearest to a change is null, by 0.008 V, 80 % of what would show. By the valve "
                             "sheets the rods hardly leak, so that dry friction or the load is another one"),
            std::string::npos)
      << page(noisy);
  EXPECT_EQ(other.find("<dd>Nothing"), std::string::npos);
  noisy.change->changed = noisy.change->parameters[0].changed = true;
  EXPECT_NE(page(noisy).find("else dry friction, the load or a leak past the piston"), std::string::npos);
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

TEST(ComparisonText, CallsNothingUntestedThatItNames) {
  const ident::Model model = model_named("io_valve", ident::Grade::good, 99.0);
  ident::PlantChange change;
  change.parameters = {{.name = "null", .role = ident::ParameterRole::valve_null, .half_width = 0.01}};
  std::vector<ComparedSubject> subjects{{.label = "base", .model = model}, {.label = "after", .model = model}};
  EXPECT_EQ(tested_sentence(change, subjects),
            "Tested: null. Not tested: what these do not describe, as friction, leaks or noise.");
  subjects[1].noise = "the output is noisier";
  EXPECT_EQ(tested_sentence(change, subjects),
            "Tested: null. Not tested: what these do not describe, as friction or leaks.");
  subjects[0].map_cause = MapCause::leak_and_valve;
  EXPECT_EQ(tested_sentence(change, subjects), "Tested: null. Not tested: what these do not describe, as friction.");
  subjects[1].map_cause = MapCause::friction;
  EXPECT_EQ(tested_sentence(change, subjects), "Tested: null. Not tested: what these do not describe.");
}

}  // namespace
}  // namespace eha::report
