// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/validation/correlation.hpp"
#include "ident/validation/score.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {
namespace {

using Vector = Eigen::VectorXd;

Vector autoregressive(double pole, Eigen::Index samples, std::mt19937_64& draw) {
  std::normal_distribution<double> normal;
  Vector signal(samples);
  double state = normal(draw) / std::sqrt(1.0 - pole * pole);
  for (double& value : signal) {
    value = state;
    state = pole * state + normal(draw);
  }
  return signal;
}

TEST(Score, MatchesFiguresWorkedOutByHand) {
  // e = {0.5, -0.5, 0, 1}: sum e^2 = 1.5; y - mean = {-1.5, -0.5, 0.5, 1.5}: sum = 5.
  const Score result = score(Eigen::Vector4d(1, 2, 3, 4), Eigen::Vector4d(0.5, 2.5, 3, 3));
  EXPECT_DOUBLE_EQ(result.r2_percent, 70.0);
  EXPECT_DOUBLE_EQ(result.fit_percent, 100.0 * (1.0 - std::sqrt(0.3)));
  EXPECT_DOUBLE_EQ(result.mse, 0.375);
  EXPECT_EQ(result.error_min, -0.5);
  EXPECT_EQ(result.error_max, 1.0);
  EXPECT_EQ(result.samples, 4U);
}

TEST(Score, IsMinusInfinityForAConstantThatIsMissedAndAHundredForOneThatIsMet) {
  const Vector constant = Vector::Constant(5, 2.0);
  EXPECT_EQ(score(constant, constant).r2_percent, 100.0);
  EXPECT_EQ(score(constant, Vector::Zero(5)).r2_percent, -std::numeric_limits<double>::infinity());
}

TEST(Score, RefusesLengthsThatDiffer) {
  EXPECT_THROW((void)score(Vector::Zero(3), Vector::Zero(4)), DataError);
  EXPECT_THROW((void)score(Vector(0), Vector(0)), DataError);
}

TEST(Autocorrelation, MatchesFiguresWorkedOutByHand) {
  // Mean 2.5 removed: {-1.5, -0.5, 0.5, 1.5}; products at lag 1: 0.75 - 0.25 + 0.75 = 1.25 of 5; at lag 2: -0.75 -
  // 0.75.
  const Correlation acf = autocorrelation(Eigen::Vector4d(1, 2, 3, 4), 2);
  EXPECT_EQ(acf.lags, (std::vector<int>{0, 1, 2}));
  EXPECT_DOUBLE_EQ(acf.values[0], 1.0);
  EXPECT_DOUBLE_EQ(acf.values[1], 0.25);
  EXPECT_DOUBLE_EQ(acf.values[2], -0.3);
  EXPECT_NEAR(acf.bound95, 1.96 / 2.0, 1e-4);
  EXPECT_NEAR(acf.bound99, 2.576 / 2.0, 1e-4);
}

TEST(Autocorrelation, IsZeroForAConstantAndShortForAShortSignal) {
  const Correlation acf = autocorrelation(Vector::Constant(3, 0.1), 20);
  EXPECT_EQ(acf.lags, (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(acf.values, (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST(Autocorrelation, RefusesWhatIsNotFinite) {
  Vector e = Vector::Ones(4);
  e(2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)autocorrelation(e, 2), DataError);
  EXPECT_THROW((void)autocorrelation(Vector(0), 2), DataError);
}

TEST(CrossCorrelation, ShowsAtAPositiveLagAResidualThatFollowsTheInput) {
  std::mt19937_64 draw(5);
  const Vector u = autoregressive(0.0, 400, draw);
  Vector e = Vector::Zero(400);
  e.tail(397) = 2.0 * u.head(397);
  const Correlation ccf = cross_correlation(e, u, 5);
  ASSERT_EQ(ccf.lags.size(), 11U);
  EXPECT_EQ(ccf.lags.front(), -5);
  for (std::size_t i = 0; i < ccf.lags.size(); ++i) {
    if (ccf.lags[i] == 3) {
      EXPECT_GT(ccf.values[i], 0.98);
    } else {
      EXPECT_LT(std::abs(ccf.values[i]), 0.2);
    }
  }
}

TEST(CrossCorrelation, IgnoresMeansAndScales) {
  std::mt19937_64 draw(6);
  const Vector u = autoregressive(0.9, 300, draw);
  const Vector e = autoregressive(0.5, 300, draw);
  const Correlation plain = cross_correlation(e, u, 4);
  const Correlation moved = cross_correlation(Vector(3.0 * e.array() + 10.0), Vector(0.1 * u.array() - 7.0), 4);
  for (std::size_t i = 0; i < plain.values.size(); ++i) EXPECT_NEAR(plain.values[i], moved.values[i], 1e-12);
  EXPECT_NEAR(plain.bound95, moved.bound95, 1e-12);
}

TEST(CrossCorrelation, RefusesLengthsThatDiffer) {
  EXPECT_THROW((void)cross_correlation(Vector::Zero(3), Vector::Zero(4), 2), DataError);
}

/// Share of runs in which independent signals leave the bound of the given level at one positive lag.
double share_outside(double residual_pole, double input_pole, bool bound99) {
  constexpr int kRuns = 2000;
  std::mt19937_64 draw(11);
  int outside = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vector e = autoregressive(residual_pole, 500, draw);
    const Vector u = autoregressive(input_pole, 500, draw);
    const Correlation ccf = cross_correlation(e, u, 3);
    if (std::abs(ccf.values.back()) > (bound99 ? ccf.bound99 : ccf.bound95)) ++outside;
  }
  return static_cast<double>(outside) / kRuns;
}

TEST(CrossCorrelation, BoundsHoldForWhiteAndForColouredSignals) {
  // 2000 runs: a true share of 0.05 stays within 0.035..0.065 with a probability of 99.8 %.
  EXPECT_NEAR(share_outside(0.0, 0.0, false), 0.05, 0.015);
  EXPECT_NEAR(share_outside(0.0, 0.95, false), 0.05, 0.015);
  EXPECT_NEAR(share_outside(0.8, 0.8, false), 0.05, 0.02);
  // With about ten independent stretches in a record the variance itself is badly known; plain 1.96 / sqrt(N) would be
  // left more than half of the time.
  EXPECT_NEAR(share_outside(0.95, 0.95, false), 0.05, 0.05);
  EXPECT_NEAR(share_outside(0.95, 0.95, true), 0.01, 0.01);
}

TEST(CrossCorrelation, BoundOfAWhiteResidualIsTheTextbookOne) {
  std::mt19937_64 draw(12);
  const Vector e = autoregressive(0.0, 5000, draw);
  const Vector u = autoregressive(0.0, 5000, draw);
  EXPECT_NEAR(cross_correlation(e, u, 3).bound95, 1.96 / std::sqrt(5000.0), 0.1 * 1.96 / std::sqrt(5000.0));
}

TEST(LjungBox, MatchesTheChiSquaredTailInClosedForm) {
  const double q1 = 100.0 * 102.0 * 0.09 / 99.0;
  const Correlation one{{0, 1}, {1.0, 0.3}, 0.0, 0.0};
  EXPECT_NEAR(ljung_box_p(one, 100), std::erfc(std::sqrt(q1 / 2.0)), 1e-12);
  const double q2 = q1 + 100.0 * 102.0 * 0.04 / 98.0;
  const Correlation two{{0, 1, 2}, {1.0, 0.3, -0.2}, 0.0, 0.0};
  EXPECT_NEAR(ljung_box_p(two, 100), std::exp(-q2 / 2.0), 1e-12);
  EXPECT_EQ(ljung_box_p(Correlation{{0}, {1.0}, 0.0, 0.0}, 100), 1.0);
}

TEST(LjungBox, RejectsWhiteNoiseAsOftenAsItsLevelSays) {
  std::mt19937_64 draw(13);
  int rejected = 0;
  for (int run = 0; run < 2000; ++run) {
    const Vector e = autoregressive(0.0, 500, draw);
    if (ljung_box_p(autocorrelation(e, 20), 500) < 0.05) ++rejected;
  }
  EXPECT_NEAR(rejected / 2000.0, 0.05, 0.02);
}

Model good_model() {
  Model model;
  model.estimation = EstimationReport{{99.0, 0.01, 90.0, -0.1, 0.1, 500}, {}, {}, 20, 0.1, "converged", true};
  ValidationReport validation;
  validation.score = {98.5, 0.01, 88.0, -0.2, 0.15, 500};
  validation.acf = {{0, 1}, {1.0, 0.01}, 0.09, 0.12};
  validation.ccf = {{-1, 0, 1, 2}, {0.9, 0.0, 0.01, 0.02}, 0.09, 0.12};
  validation.ljung_box_p = 0.4;
  validation.tests = ResidualTests{1, {20.0, 21, 0.5}, {19.0, 19, 0.5}};
  validation.extrapolated_percent = 0.0;
  model.validation = validation;
  model.stability = StabilityReport{true, "matignon", 0.5};
  return model;
}

TEST(Verdict, AcceptsWithoutAWordWhatMeetsEveryLimit) {
  const Verdict verdict = judge(good_model(), AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  EXPECT_EQ(verdict.grade, Grade::good);
  EXPECT_TRUE(verdict.reasons.empty());
  for (const Criterion& c : verdict.criteria) EXPECT_TRUE(c.passed) << c.name;
}

TEST(Verdict, RejectsWhatWasFittedToSamplesThatWereNotMeasured) {
  EXPECT_TRUE(judge(good_model(), {}, {.interpolated_percent = kMostInterpolated_percent}).accepted);
  const Verdict verdict = judge(good_model(), {}, {.interpolated_percent = 62.1});
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict.reasons.front(),
            "62.1 % of the record was not measured but interpolated, which is above the limit of 1 %.");
}

TEST(Verdict, LowersWhatErrsMoreThanTheMeasuredNoise) {
  Model model = good_model();
  model.validation->score.mse = 0.04;
  EXPECT_EQ(judge(model, {}, {.noise_std = 0.07}).grade, Grade::good);
  const Verdict verdict = judge(model, {}, {.noise_std = 0.05});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_EQ(verdict.reasons.front(),
            "The validation error of 0.2 in (rms) is 4 times the noise of 0.05 in that differs between the record's "
            "periods, more than 3: the model misses a part of the plant.");
  EXPECT_EQ(judge(model, {}).grade, Grade::good) << "without a measured noise nothing is compared";
}

TEST(Verdict, RejectsWithEveryReasonAtOnceGivingValueAndLimit) {
  Model model = good_model();
  model.estimation->converged = false;
  model.estimation->termination = "evaluation limit";
  model.validation->score.r2_percent = 85.1234;
  model.validation->offset_reestimated = Score{91.2, 0, 0, 0, 0, 500};
  model.validation->score.error_min = -0.75;
  model.stability = StabilityReport{false, "argument_principle", -0.25};
  AcceptanceLimits limits;
  limits.max_abs_error = 0.5;
  const Verdict verdict = judge(model, limits);
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(
      verdict.reasons,
      (std::vector<std::string>{
          "The estimation did not converge: it ended after 20 evaluations with \"evaluation limit\".",
          "The validation R2 of 85.12 % is below the limit of 90 %.",
          "The greatest validation error of 0.75 in is above the limit of 0.5 in.",
          "The model is unstable (test: argument_principle, margin -0.25 rad), and the limits require a stable one.",
          "The residual correlates with future input more than with past input: input and output may be exchanged, or "
          "a "
          "controller closes the loop.",
          "With the offset estimated anew on the validation part R2 is 91.2 %: the sensor or an offset drifts "
          "between the two parts."}));
}

TEST(Verdict, SaysHowAnIntegratingModelIsAccepted) {
  Model model = good_model();
  model.transfer_function.numerator = {{1.0, 0.0}};
  model.transfer_function.denominator = {{1.0, 2.0}, {0.5, 1.0}, {0.0, 0.0}};
  model.stability = StabilityReport{false, "matignon", 0.0};
  EXPECT_FALSE(judge(model, {}).accepted);
  EXPECT_NE(judge(model, {}).reasons.front().find("require_stable = false"), std::string::npos);
  AcceptanceLimits limits;
  limits.require_stable = false;
  EXPECT_TRUE(judge(model, limits).accepted);
  // With another pole in the right half plane the model is not a mere integrator.
  model.transfer_function.denominator = {{1.0, 2.0}, {-1.0, 1.0}};
  EXPECT_NE(judge(model, {}).reasons.front().find("unstable"), std::string::npos);
}

TEST(Verdict, AcceptsAPoleAt0ThatTheStructureDeclares) {
  Model model = good_model();
  model.transfer_function = {{{1.0, 0.0}}, {{0.1, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  model.stability = stability_beside_integrator(model.transfer_function);
  EXPECT_EQ(model.stability->integrator_order, 1.0);
  EXPECT_NEAR(model.stability->margin_rad, 0.5 * std::numbers::pi, 1e-12);
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  // Not with another pole that grows, or at 0.
  model.transfer_function.denominator = {{0.1, 2.0}, {-1.0, 1.0}};
  model.stability = stability_beside_integrator(model.transfer_function);
  EXPECT_FALSE(judge(model, {}).accepted);
}

TEST(Verdict, AcceptsAFlatRidgeWithANote) {
  Model model = good_model();
  model.estimation->termination = std::string(text(Termination::flat_ridge));
  const Verdict verdict = judge(model, {});
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("flat along a ridge"), std::string::npos);
}

TEST(Verdict, RejectsAMarginBelowItsLimitAndAStabilityNobodyDetermined) {
  Model model = good_model();
  AcceptanceLimits limits;
  limits.min_stability_margin_rad = 0.6;
  EXPECT_EQ(judge(model, limits).reasons,
            (std::vector<std::string>{"The stability margin of 0.5 rad is below the limit of 0.6 rad."}));
  EXPECT_FALSE(judge(model, limits).accepted);
  model.stability.reset();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
}

TEST(Verdict, LetsAnUnstableModelPassOnlyWhereTheLimitsAllowItAndSaysSo) {
  Model model = good_model();
  model.stability = StabilityReport{false, "matignon", -0.1};
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  AcceptanceLimits limits;
  limits.require_stable = false;
  const Verdict verdict = judge(model, limits);
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
}

TEST(Verdict, DoesNotLetAFigureThatIsNotANumberPass) {
  Model model = good_model();
  model.validation->score.r2_percent = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  model = good_model();
  model.validation->score.error_max = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
}

TEST(Verdict, GradesAModelWhoseResidualTellsSomethingAsUsable) {
  Model model = good_model();
  // Single lags out of their bounds and colour say nothing: the joint tests do.
  model.validation->ccf.values = {0.9, 0.5, 0.3, -0.4};
  model.validation->ljung_box_p = 1e-5;
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
  model.validation->tests->input.p = 0.009;
  model.validation->tests->whiteness.p = 1e-5;
  const Verdict verdict = judge(model, AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_EQ(verdict.reasons,
            (std::vector<std::string>{
                "The residual correlates with past input (p = 0.009 for lags 0 to 20 together): the model may miss a "
                "part of the plant.",
                "The residual is no autoregressive noise of order 1 (p = 1e-05 for lags 1 to 20 together)."}));
}

const Criterion& criterion_of(const Verdict& verdict, const std::string& name) {
  return *std::find_if(verdict.criteria.begin(), verdict.criteria.end(), [&](const auto& c) { return c.name == name; });
}

TEST(Verdict, DoesNotJudgeResidualsByTooFewSamples) {
  Model model = good_model();
  model.validation->score.samples = 60;
  Verdict verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "residual_input_p").judged);
  EXPECT_TRUE(criterion_of(verdict, "residual_whiteness_p").passed);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("with 60 validating samples the test would rather overlook"), std::string::npos);
  // What it shows all the same, it shows.
  model.validation->tests->input.p = 0.001;
  verdict = judge(model, {});
  EXPECT_TRUE(criterion_of(verdict, "residual_input_p").judged);
  EXPECT_NE(verdict.reasons[0].find("correlates with past input"), std::string::npos);
  model.validation->tests.reset();
  verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "residual_whiteness_p").judged);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("are too few for the residual's tests"), std::string::npos);
}

TEST(Verdict, DoesNotJudgeAnErrorWhoseNoiseIsNotKnown) {
  EXPECT_EQ(judge(good_model(), {}).grade, Grade::good) << "an excitation that does not repeat";
  const Verdict verdict = judge(good_model(), {}, {.lacks_periods = true});
  EXPECT_EQ(verdict.grade, Grade::usable);
  EXPECT_FALSE(criterion_of(verdict, "error_over_noise").judged);
  EXPECT_NE(verdict.reasons.at(0).find("too few periods"), std::string::npos);
}

TEST(Verdict, GradesExtrapolationAsUsable) {
  Model model = good_model();
  model.validation->extrapolated_percent = 5.1;
  EXPECT_EQ(judge(model, {}).grade, Grade::usable);
}

/// A model of two free orders and one free coefficient, all of them determined.
Model identified_model() {
  Model model = good_model();
  model.parameters = {{"a2", 0.6, 0.01, 0.58, 0.62, false, ParameterRole::denominator_coefficient},
                      {"n2", 1.75, 0.15, 1.45, 2.05, false, ParameterRole::denominator_order},
                      {"n1", 0.9, 0.01, 0.88, 0.92, false, ParameterRole::denominator_order}};
  model.estimation->correlation = ParameterCorrelation{};
  model.estimation->information = InformationCriteria{};
  model.estimation->information->left_out = {{"n2", 10.0}, {"n1", 10.0}};
  return model;
}

TEST(Verdict, NamesTheOrderThatARecordDoesNotDetermine) {
  EXPECT_EQ(judge(identified_model(), {}).grade, Grade::good);
  Model model = identified_model();
  model.parameters[1].value = 2.49;
  model.parameters[1].std = 0.70;
  Verdict verdict = judge(model, {});
  EXPECT_FALSE(verdict.accepted);
  EXPECT_EQ(verdict.reasons, (std::vector<std::string>{"n2 = 2.49 +- 0.30: its standard error of 0.7 exceeds 0.15."}));
  model = identified_model();
  model.estimation->information->left_out[1].rise = -3.21;
  verdict = judge(model, {});
  EXPECT_EQ(verdict.grade, Grade::rejected);
  EXPECT_EQ(
      verdict.reasons,
      (std::vector<std::string>{"n1 = 0.900 +- 0.020: leaving its term out costs -3.2 of AR-BIC, less than 10."}));
}

TEST(Verdict, RejectsACoefficientThatMayBe0) {
  Model model = identified_model();
  model.parameters[0].lower95 = 0.0;
  EXPECT_EQ(judge(model, {}).grade, Grade::rejected);
  EXPECT_EQ(judge(model, {}).reasons.front(), "a2 = 0.60 +- 0.31: compatible with 0, its 95 % interval is 0 to 0.62.");
  // A coefficient that the structure or a request holds is not asked.
  model.parameters[0].fixed = true;
  EXPECT_EQ(judge(model, {}).grade, Grade::good);
}

TEST(Verdict, JudgesAModelWithoutValidationByItsEstimationAndSaysSo) {
  Model model = good_model();
  model.validation.reset();
  const Verdict verdict = judge(model, AcceptanceLimits{});
  EXPECT_TRUE(verdict.accepted);
  ASSERT_EQ(verdict.reasons.size(), 1U);
  EXPECT_NE(verdict.reasons[0].find("Nothing was kept for validation"), std::string::npos);
  EXPECT_EQ(verdict.grade, Grade::usable);
  model.estimation->score.r2_percent = 50.0;
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
  model.estimation.reset();
  EXPECT_FALSE(judge(model, AcceptanceLimits{}).accepted);
}

}  // namespace
}  // namespace eha::ident
