// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of reports, but for comparisons and Bode plots.
#include "daemon/report/figures.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/report/comparison_page.hpp"
#include "daemon/report/html.hpp"
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

}  // namespace
}  // namespace eha::report
