// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/report/figures.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "tests/unit/report/subjects.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::report {
namespace {

using eha::test::TemporaryFolder;

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

}  // namespace
}  // namespace eha::report
