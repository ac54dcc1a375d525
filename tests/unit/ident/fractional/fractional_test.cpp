// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "core/error.hpp"
#include "ident/fractional/simulate.hpp"
#include "ident/fractional/stability.hpp"
#include "tests/unit/shared_data.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

TransferFunction second_order(double natural_rad_s, double damping) {
  return {{{natural_rad_s * natural_rad_s, 0.0}},
          {{1.0, 2.0}, {2.0 * damping * natural_rad_s, 1.0}, {natural_rad_s * natural_rad_s, 0.0}},
          0.0};
}

double second_order_step(double natural_rad_s, double damping, double t) {
  if (t < 0.0) return 0.0;
  const double damped = natural_rad_s * std::sqrt(1.0 - damping * damping);
  return 1.0 - std::exp(-damping * natural_rad_s * t) *
                   (std::cos(damped * t) + damping * natural_rad_s / damped * std::sin(damped * t));
}

Eigen::VectorXd random_input(Eigen::Index samples, unsigned seed) {
  std::mt19937_64 generator(seed);
  Eigen::VectorXd u(samples);
  for (double& value : u) value = static_cast<double>(generator() >> 11) * 0x1p-53 - 0.5;
  return u;
}

class StepReferences : public testing::TestWithParam<double> {};

TEST_P(StepReferences, AreMetByTheExactMethodAtEveryPoint) {
  const auto path = test::shared("refs/step_refs.json");
  EHA_REQUIRE_SHARED(path);
  const double step_s = GetParam();
  const auto references = nlohmann::json::parse(std::ifstream(path));
  for (const auto& [name, reference] : references.items()) {
    TransferFunction g;
    for (const auto& term : reference["numerator"]) g.numerator.push_back({term[0], term[1]});
    for (const auto& term : reference["denominator"]) g.denominator.push_back({term[0], term[1]});
    const auto samples = static_cast<Eigen::Index>(std::lround(20.0 / step_s)) + 1;
    const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(samples), step_s);
    double worst = 0.0;
    for (std::size_t i = 0; i < reference["time_s"].size(); ++i) {
      const auto k = static_cast<Eigen::Index>(std::lround(reference["time_s"][i].get<double>() / step_s));
      worst = std::max(worst, std::abs(y[k] - reference["step"][i].get<double>()));
    }
    EXPECT_LT(worst / y.cwiseAbs().maxCoeff(), 1e-9) << name;
    RecordProperty(name, std::to_string(worst / y.cwiseAbs().maxCoeff()));
  }
}

INSTANTIATE_TEST_SUITE_P(SamplePeriods, StepReferences, testing::Values(0.04, 0.01, 0.001));

TEST(ExactSimulation, FollowsALightlyDampedModeAndPolesAboveNyquist) {
  // 200 rad/s at 1 ms lies inside the band, 5000 and 12000 rad/s above the Nyquist frequency of 3142 rad/s.
  for (const double natural_rad_s : {200.0, 5000.0, 12000.0}) {
    const TransferFunction g = second_order(natural_rad_s, 0.01);
    const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(2000), 0.001);
    double worst = 0.0;
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      worst = std::max(worst, std::abs(y[k] - second_order_step(natural_rad_s, 0.01, 0.001 * static_cast<double>(k))));
    }
    EXPECT_LT(worst / y.cwiseAbs().maxCoeff(), 1e-9) << natural_rad_s << " rad/s";
  }
}

TEST(ExactSimulation, ShiftsByAnyDelay) {
  const TransferFunction plain = second_order(7.0, 0.3);
  for (const double delay_s : {0.0, 0.004, 0.01, 0.0349, 0.1, 0.10001, 0.5}) {
    TransferFunction g = plain;
    g.delay_s = delay_s;
    const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(500), 0.01);
    double worst = 0.0;
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      worst = std::max(worst, std::abs(y[k] - second_order_step(7.0, 0.3, 0.01 * static_cast<double>(k) - delay_s)));
    }
    EXPECT_LT(worst, 1e-9) << delay_s << " s";
  }
}

TEST(ExactSimulation, DelaysAFirstOrderLagWhoseStepHasAKink) {
  for (const double delay_s : {0.0, 0.003, 0.0149, 0.0151, 0.2}) {
    const TransferFunction g{{{1.0, 0.0}}, {{0.05, 1.0}, {1.0, 0.0}}, delay_s};
    const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(300), 0.01);
    for (Eigen::Index k = 0; k < y.size(); ++k) {
      const double t = 0.01 * static_cast<double>(k) - delay_s;
      ASSERT_NEAR(y[k], t > 0.0 ? 1.0 - std::exp(-t / 0.05) : 0.0, 1e-9) << delay_s << " s, sample " << k;
    }
  }
}

TEST(ExactSimulation, PassesADirectPartOneSampleLate) {
  // (s + 3)/(s + 1) = 1 + 2/(s + 1); a held input takes effect after the sample is read.
  const TransferFunction g{{{1.0, 1.0}, {3.0, 0.0}}, {{1.0, 1.0}, {1.0, 0.0}}, 0.0};
  const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(400), 0.01);
  EXPECT_NEAR(y[0], 0.0, 1e-9);
  for (Eigen::Index k = 1; k < y.size(); ++k) {
    ASSERT_NEAR(y[k], 1.0 + 2.0 * (1.0 - std::exp(-0.01 * static_cast<double>(k))), 1e-8) << k;
  }
}

TEST(ExactSimulation, IsLinearAndCausal) {
  const TransferFunction g{{{0.6, 0.0}}, {{0.8, 1.75}, {1.3, 0.9}, {0.05, 0.0}}, 0.0123};
  const Eigen::VectorXd u = random_input(1500, 1);
  const Eigen::VectorXd v = random_input(1500, 2);
  const Eigen::VectorXd sum = simulate(g, 2.0 * u - 3.0 * v, 0.01);
  const Eigen::VectorXd parts = 2.0 * simulate(g, u, 0.01) - 3.0 * simulate(g, v, 0.01);
  EXPECT_LT((sum - parts).cwiseAbs().maxCoeff(), 1e-9 * sum.cwiseAbs().maxCoeff());
  Eigen::VectorXd later = u;
  later.tail(700).setConstant(5.0);
  const Eigen::VectorXd y = simulate(g, u, 0.01);
  const Eigen::VectorXd changed = simulate(g, later, 0.01);
  EXPECT_LT((y - changed).head(800).cwiseAbs().maxCoeff(), 1e-9 * changed.cwiseAbs().maxCoeff());
}

TEST(ExactSimulation, RefusesAnUnstableModelAndSaysWhatToDo) {
  const TransferFunction g{{{1.0, 0.0}}, {{1.0, 1.5}, {-0.3, 0.7}, {-0.1, 0.0}}, 0.0};
  try {
    static_cast<void>(simulate(g, Eigen::VectorXd::Ones(100), 0.01));
    FAIL() << "simulated an unstable model";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("gl1"), std::string::npos);
  }
}

/// The scheme as a textbook states it, term by term.
Eigen::VectorXd plain_recursion(const TransferFunction& g, const Eigen::VectorXd& u, double h) {
  const Eigen::Index n_samples = u.size();
  Eigen::VectorXd y(n_samples);
  const auto weights = [&](double order) {
    std::vector<long double> w(static_cast<std::size_t>(n_samples), 1.0L);
    for (std::size_t j = 1; j < w.size(); ++j) {
      w[j] = w[j - 1] * (static_cast<long double>(j) - 1.0L - static_cast<long double>(order)) /
             static_cast<long double>(j);
    }
    return w;
  };
  std::vector<std::vector<long double>> a;
  std::vector<std::vector<long double>> b;
  for (const Term& term : g.denominator) a.push_back(weights(term.order));
  for (const Term& term : g.numerator) b.push_back(weights(term.order));
  for (Eigen::Index n = 0; n < n_samples; ++n) {
    long double right = 0.0L;
    long double first = 0.0L;
    for (std::size_t j = 0; j < g.numerator.size(); ++j) {
      const long double scale = g.numerator[j].coefficient / std::pow(h, g.numerator[j].order);
      for (Eigen::Index k = 0; k <= n; ++k) right += scale * b[j][static_cast<std::size_t>(k)] * u[n - k];
    }
    for (std::size_t i = 0; i < g.denominator.size(); ++i) {
      const long double scale = g.denominator[i].coefficient / std::pow(h, g.denominator[i].order);
      first += scale;
      for (Eigen::Index k = 1; k <= n; ++k) right -= scale * a[i][static_cast<std::size_t>(k)] * y[n - k];
    }
    y[n] = static_cast<double>(right / first);
  }
  return y;
}

TEST(GrunwaldLetnikov, EqualsThePlainRecursion) {
  const std::vector<TransferFunction> models = {
      {{{1.0, 0.0}}, {{1.0, 0.5}, {1.0, 0.0}}, 0.0},
      {{{1.0, 0.0}}, {{0.8, 2.2}, {0.5, 0.9}, {1.0, 0.0}}, 0.0},
      {{{0.6, 0.0}}, {{0.8, 1.75}, {1.3, 0.9}, {0.05, 0.0}}, 0.0},
      {{{0.4, 0.3}, {0.6, 0.0}}, {{0.8, 1.75}, {1.3, 0.9}, {0.05, 0.0}}, 0.0},
      // Of integer orders, whose kernels end; the second grows, to e^10 at the last row.
      {{{0.3, 1.0}, {0.6, 0.0}}, {{0.2, 2.0}, {1.3, 1.0}, {0.05, 0.0}}, 0.0},
      {{{0.3, 1.0}, {0.6, 0.0}}, {{0.2, 2.0}, {1.0, 1.0}, {-0.6, 0.0}}, 0.0},
  };
  for (const TransferFunction& g : models) {
    for (const Eigen::Index samples : {300, 2000}) {
      const Eigen::VectorXd u = random_input(samples, 3);
      const Eigen::VectorXd expected = plain_recursion(g, u, 0.01);
      const Eigen::VectorXd y = simulate(g, u, 0.01, SimulationMethod::gl1);
      EXPECT_LT((y - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff()) << samples;
    }
  }
}

TEST(GrunwaldLetnikov, LetsAnUnstableModelGrow) {
  const TransferFunction g{{{1.0, 0.0}}, {{1.0, 1.0}, {-1.0, 0.0}}, 0.0};
  const Eigen::VectorXd y = simulate(g, Eigen::VectorXd::Ones(2001), 0.01, SimulationMethod::gl1);
  EXPECT_NEAR(y[2000] / std::exp(20.0), 1.0, 0.12);
}

TEST(ConvolutionQuadrature, ConvergesToTheExactStepOfAHalfOrderLag) {
  const TransferFunction g{{{1.0, 0.0}}, {{1.0, 0.5}, {1.0, 0.0}}, 0.0};
  // 1 - exp(t) erfc(sqrt t) at t = 5
  const double exact = 1.0 - std::exp(5.0) * std::erfc(std::sqrt(5.0));
  const auto error = [&](double h) {
    const auto k = static_cast<Eigen::Index>(std::lround(5.0 / h));
    return std::abs(simulate(g, Eigen::VectorXd::Ones(k + 1), h, SimulationMethod::cq2)[k] - exact);
  };
  EXPECT_LT(error(0.01), 1e-4);
  EXPECT_GT(error(0.02) / error(0.01), 1.8);
}

TEST(Stability, CountsThePolesOfASectorAsThePolynomialHasThem) {
  // (s^2 - 2 s cos(60 deg) + 1)(s + 1): poles at +-60 degrees and 180 degrees.
  const std::vector<Term> d = {{1.0, 3.0}, {0.0, 2.0}, {0.0, 1.0}, {1.0, 0.0}};
  EXPECT_EQ(zeros_in_sector(d, 59.0 * pi / 180.0), 0);
  EXPECT_EQ(zeros_in_sector(d, 61.0 * pi / 180.0), 2);
}

TEST(Stability, GivesTheMarginOfAnExactCommensurateModel) {
  // s^1.5 + 1 with q = 1.5: s^1.5 = exp(+-i pi), so arg s = pi/1.5.
  const TransferFunction g{{{1.0, 0.0}}, {{1.0, 1.5}, {1.0, 0.0}}, 0.0};
  const StabilityReport report = stability(g);
  EXPECT_EQ(report.test, "matignon");
  EXPECT_TRUE(report.stable);
  EXPECT_NEAR(report.margin_rad, pi / 1.5 - pi / 2.0, 1e-9);
}

TEST(Stability, AgreesBetweenBothTestsWhereBothApply) {
  // Orders 2.2 and 0.9 have the base 0.1; a hair off it only the argument principle applies.
  const TransferFunction whole{{{1.0, 0.0}}, {{0.8, 2.2}, {0.5, 0.9}, {1.0, 0.0}}, 0.0};
  const TransferFunction off{{{1.0, 0.0}}, {{0.8, 2.2}, {0.5, 0.9 + 1e-7}, {1.0, 0.0}}, 0.0};
  const StabilityReport a = stability(whole);
  const StabilityReport b = stability(off);
  EXPECT_EQ(a.test, "matignon");
  EXPECT_EQ(b.test, "argument_principle");
  EXPECT_EQ(a.stable, b.stable);
  EXPECT_NEAR(a.margin_rad, b.margin_rad, 1e-6);
}

TEST(Stability, FindsALightlyDampedPoleOnEitherSideOfTheAxis) {
  for (const double damping : {1e-4, 1e-3, 0.05}) {
    EXPECT_FALSE(grows(second_order(30.0, damping)));
    EXPECT_TRUE(grows({{{1.0, 0.0}}, {{1.0, 2.0}, {-damping, 1.0 + 1e-7}, {1.0, 0.0}}, 0.0})) << damping;
    EXPECT_FALSE(grows({{{1.0, 0.0}}, {{1.0, 2.0}, {damping, 1.0 + 1e-7}, {1.0, 0.0}}, 0.0})) << damping;
  }
}

TEST(Stability, DecidesOrdersThatAlmostAgreeAsIfTheyDid) {
  // Between two such orders the dominant term changes over millions of decades.
  for (const double gap : {3e-4, 1e-7, 3e-9}) {
    const TransferFunction stable{{{1.0, 0.0}}, {{0.45, 1.9934 + gap}, {1.0, 1.9934}, {2.2e5, 0.0}}, 0.0};
    const TransferFunction growing{{{1.0, 0.0}}, {{0.45, 2.1 + gap}, {1.0, 2.1}, {2.2e5, 0.0}}, 0.0};
    // Roots of s^n = -2.2e5/1.45 lie at the angle pi/n.
    EXPECT_NEAR(stability(stable).margin_rad, pi / 1.9934 - 0.5 * pi, 1e-3);
    EXPECT_FALSE(grows(stable));
    EXPECT_NEAR(stability(growing).margin_rad, pi / 2.1 - 0.5 * pi, 1e-3);
    EXPECT_TRUE(grows(growing));
  }
}

TEST(Stability, CountsWhatIsNoPlantAsGrowingAtOnce) {
  const TransferFunction steep{{{1.0, 0.0}}, {{3.03e10, 2.043e7}, {3.04e10, 2.04e7}, {1.0, 0.0}}, 0.0};
  const TransferFunction endless{{{1.0, 0.0}}, {{INFINITY, 2.1}, {1.0, 0.97}, {1.0, 0.0}}, 0.0};
  const TransferFunction sunken{{{1.0, 0.0}}, {{8.88e-12, -5.5e8}, {1.0, 0.999}, {1.5, 0.0}}, 0.0};
  for (const TransferFunction& g : {steep, endless, sunken}) {
    EXPECT_TRUE(grows(g));
    EXPECT_FALSE(stability(g).stable);
  }
}

TEST(Stability, CallsAnIntegratorNeitherStableNorGrowing) {
  const TransferFunction g{{{1.0, 0.0}}, {{1.0, 2.0}, {1.0, 1.0}}, 0.0};
  EXPECT_FALSE(grows(g));
  EXPECT_FALSE(stability(g).stable);
}

}  // namespace
}  // namespace eha::ident
