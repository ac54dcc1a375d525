// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/usable_band.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "ident/estimation/fit.hpp"
#include "ident/excitation/prms.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using namespace synthetic;

constexpr double kStep_s = 0.05;

/// A model whose gain alone is uncertain, and the more the higher its corner.
struct Known {
  Model model;
  ParameterCovariance covariance;
};

Known lag_with_uncertain_corner(double std) {
  Known known;
  known.model.transfer_function = {{{2.0, 0.0}}, {{1.0, 1.0}, {1.0, 0.0}}, 0.0};
  known.covariance.parameters = {coefficient_key(0)};
  known.covariance.matrix = Eigen::MatrixXd::Constant(1, 1, std * std);
  return known;
}

TEST(ExcitedBand, ReachesFromTheLowestToTheHighestTone) {
  const auto band = excited_band(excitation(kStep_s), kStep_s);
  ASSERT_TRUE(band);
  // Half a line of the 50 s record either way.
  EXPECT_NEAR(band->lowest_Hz, 0.05, 0.01);
  EXPECT_NEAR(band->highest_Hz, 0.65, 0.01);
}

TEST(ExcitedBand, OfASignalOfManyLevelsReachesTowardsOneOverTheHold) {
  const Eigen::VectorXd u = Prms{.amplitude_V = 1.0, .levels = 5, .hold_s = 0.5, .seed = 3}.volts(kStep_s, 4000);
  const auto band = excited_band(u, kStep_s);
  ASSERT_TRUE(band);
  EXPECT_LT(band->lowest_Hz, 0.1);
  EXPECT_GT(band->highest_Hz, 1.2);
}

TEST(ExcitedBand, OfALongRecordKeepsTheLineOfATone) {
  constexpr Eigen::Index kRows = 300'000;
  constexpr double kTone_Hz = 0.4;
  const Eigen::ArrayXd time_s = Eigen::ArrayXd::LinSpaced(kRows, 0.0, static_cast<double>(kRows - 1)) * kStep_s;
  const Eigen::VectorXd u = 3.0 + (2.0 * std::numbers::pi * kTone_Hz * time_s).cos();
  const auto band = excited_band(u, kStep_s);
  ASSERT_TRUE(band);
  // Half a line of the record either way.
  const double half_line_Hz = 0.5 / (static_cast<double>(kRows) * kStep_s);
  EXPECT_NEAR(band->lowest_Hz, kTone_Hz, half_line_Hz);
  EXPECT_NEAR(band->highest_Hz, kTone_Hz, half_line_Hz);
}

TEST(ExcitedBand, OfAConstantInputIsNone) {
  EXPECT_FALSE(excited_band(Eigen::VectorXd::Constant(100, 1.3), kStep_s));
  EXPECT_FALSE(excited_band(Eigen::VectorXd::Zero(100), kStep_s));
}

TEST(UsableBand, OfASingleLineIsThatLineWhereTheRecordDeterminesIt) {
  const auto [model, covariance] = lag_with_uncertain_corner(1e-6);
  const auto band = usable_band(model, covariance, {1.25, 1.25}, {});
  ASSERT_TRUE(band);
  EXPECT_DOUBLE_EQ(band->lowest_Hz, 1.25);
  EXPECT_DOUBLE_EQ(band->highest_Hz, 1.25);
  const Known unknown = lag_with_uncertain_corner(30.0);
  EXPECT_FALSE(usable_band(unknown.model, unknown.covariance, {0.01, 0.01}, {}));
}

TEST(UsableBand, EndsBelowTheNyquistFrequency) {
  auto [model, covariance] = lag_with_uncertain_corner(1e-6);
  model.estimation.emplace().compared_step_s = 0.08;
  const auto band = usable_band(model, covariance, {0.025, 6.25}, {});
  ASSERT_TRUE(band);
  EXPECT_DOUBLE_EQ(band->highest_Hz, 5.0);
  EXPECT_FALSE(usable_band(model, covariance, {5.5, 6.25}, {}));
}

TEST(UsableBand, EndsWhereTheStandardErrorPassesItsLimit) {
  // |d ln G / d a0| = 1 / |1 + s|, real part 1 / (1 + w^2): 1 dB is 0.1151 in ln|G|.
  const double std = 0.3;
  const auto [model, covariance] = lag_with_uncertain_corner(std);
  AcceptanceLimits limits;
  limits.usable_phase_error_deg = 90.0;
  const auto band = usable_band(model, covariance, {0.01, 10.0}, limits);
  ASSERT_TRUE(band);
  const double corner_Hz = std::sqrt(std * 20.0 / std::log(10.0) - 1.0) / (2.0 * std::numbers::pi);
  EXPECT_NEAR(band->lowest_Hz, corner_Hz, 0.04 * corner_Hz);
  EXPECT_DOUBLE_EQ(band->highest_Hz, 10.0);
  // The phase's error, std w / (1 + w^2), exceeds 5 degrees around the corner: the wider side is kept.
  limits.usable_gain_error_dB = 20.0;
  limits.usable_phase_error_deg = 5.0;
  EXPECT_GT(usable_band(model, covariance, {0.01, 10.0}, limits)->lowest_Hz, 0.16);
}

TEST(AgreeingBand, EndsWhereGainOrPhaseDiffer) {
  const auto lag = [](double gain, double T_s) {
    Model model;
    model.transfer_function = {{{gain, 0.0}}, {{T_s, 1.0}, {1.0, 0.0}}, 0.0};
    return model;
  };
  const FrequencyInterval band{0.001, 10.0};
  const auto shared = agreeing_band(lag(2.0, 0.1), lag(2.0, 0.5), band, {});
  ASSERT_TRUE(shared);
  EXPECT_DOUBLE_EQ(shared->lowest_Hz, 0.001);
  // atan(0.5 w) - atan(0.1 w) is 10 degrees at 0.0724 Hz, before the gains are 1 dB apart.
  EXPECT_NEAR(shared->highest_Hz, 0.0724, 0.004);
  EXPECT_FALSE(agreeing_band(lag(2.0, 0.1), lag(-2.0, 0.1), band, {}));
  EXPECT_FALSE(agreeing_band(lag(2.0, 0.1), lag(2.5, 0.1), band, {}));
}

TEST(UsableBand, IsNoneWhereNothingIsKnown) {
  const AcceptanceLimits limits;
  Known known = lag_with_uncertain_corner(30.0);
  EXPECT_FALSE(usable_band(known.model, known.covariance, {0.001, 0.01}, limits));
  EXPECT_FALSE(usable_band(known.model, {}, {0.001, 0.01}, limits));
  known = lag_with_uncertain_corner(1e-6);
  EXPECT_TRUE(usable_band(known.model, known.covariance, {0.001, 0.01}, limits));
  // The covariance leaves out what the record does not determine.
  known.model.parameters.push_back(
      {"a0", 1.0, std::numeric_limits<double>::infinity(), 0.0, 0.0, false, ParameterRole::denominator_coefficient});
  EXPECT_FALSE(usable_band(known.model, known.covariance, {0.001, 0.01}, limits));
}

TEST(UsableBand, OfAFittedModelHoldsTheTruthWithinItsErrors) {
  const Model truth = fractional(0.6, 1.75, 0.9, 0.3, 0.46);
  const FitResult result = fit(record_of(truth, kStep_s, 0.01, 4), asked_for(structures::fo()), {});
  const auto band = usable_band(result.model, result.covariance, {0.05, 0.65}, {});
  ASSERT_TRUE(band);
  const std::vector<double> ends{band->lowest_Hz, band->highest_Hz};
  const BodeCurve fitted = bode_curve(result.model, ends, {});
  const BodeCurve true_curve = bode_curve(truth, ends, {});
  for (std::size_t i = 0; i < ends.size(); ++i) {
    EXPECT_NEAR(fitted.gain_dB[i], true_curve.gain_dB[i], 3.0) << ends[i];
    EXPECT_NEAR(fitted.phase_deg[i], true_curve.phase_deg[i], 30.0) << ends[i];
  }
}

TEST(Resonance, IsTheHighestPeakOfTheGain) {
  Model model;
  model.transfer_function = {{{1.0, 0.0}}, {{1.0, 2.0}, {0.2, 1.0}, {100.0, 0.0}}, 0.0};
  const auto peak_Hz = resonance_Hz(model, {0.05, 0.65});
  ASSERT_TRUE(peak_Hz);
  EXPECT_NEAR(*peak_Hz, 10.0 / (2.0 * std::numbers::pi), 0.06);
  EXPECT_FALSE(resonance_Hz(lag_with_uncertain_corner(1.0).model, {0.05, 0.65}));
}

}  // namespace
}  // namespace eha::ident
