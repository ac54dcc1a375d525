// SPDX-License-Identifier: GPL-3.0-or-later
// Plants like those of foreign records that were hard to fit: light damping, long and fast records, integrators.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/estimation/variants.hpp"
#include "ident/search/global_search.hpp"
#include "ident/search/realisation.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;
using synthetic::normal;

/// The response of a model to a random input, each value held for `hold` rows, with white noise.
Record record_of(const Model& model, double step_s, Eigen::Index rows, int hold, double noise) {
  std::mt19937_64 generator(11);
  Record record;
  record.step_s = step_s;
  record.input.resize(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    record.input[k] = k % hold == 0 ? normal(generator) : record.input[k - 1];
  }
  record.output = simulate(model, record.input, step_s);
  const double spread = std::sqrt((record.output.array() - record.output.mean()).square().mean());
  for (double& y : record.output) y += noise * spread * normal(generator);
  return record;
}

StructureOptions integer(int poles, int zeros) {
  StructureOptions asked;
  asked.structure = structures::io({poles, zeros});
  return asked;
}

/// A flexible arm: two hardly damped modes, moving before the record.
Model arm() {
  // (s^2 + 3.4 s + 184^2)(s^2 + 3.8 s + 398^2)
  Model model;
  model.transfer_function = {{{-25.0, 3.0}, {-3.1e4, 2.0}, {7.4e5, 1.0}, {1.8e8, 0.0}},
                             {{1.0, 4.0},
                              {7.2, 3.0},
                              {3.4 * 3.8 + 184.0 * 184.0 + 398.0 * 398.0, 2.0},
                              {3.4 * 398.0 * 398.0 + 3.8 * 184.0 * 184.0, 1.0},
                              {184.0 * 184.0 * 398.0 * 398.0, 0.0}},
                             0.0};
  model.initial_state = {2e5, -6e3, -0.6, -0.1};
  return model;
}

TEST(Search, FindsHardlyDampedModesFromEverySeed) {
  const Record record = record_of(arm(), 0.002, 1024, 1, 0.05);
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    FitOptions options;
    options.seed = seed;
    const Model model = fit(record, integer(4, 3), options).model;
    // 5 % of noise leaves 99.75 % of the variance.
    EXPECT_GT(model.estimation->score.r2_percent, 99.7) << "seed " << seed;
    EXPECT_GT(model.validation->score.r2_percent, 99.5) << "seed " << seed;
  }
}

TEST(Search, FindsAFastResonanceInALongRecord) {
  // 70 Hz in 40 000 rows at 610 Hz: too many rows for a search at full rate, too fast for one at a tenth of it.
  Model plant;
  plant.transfer_function = {{{1.9e5, 0.0}}, {{1.0, 2.0}, {44.0, 1.0}, {1.9e5, 0.0}}, 0.0};
  Record record = record_of(plant, 0.00164, 40000, 1, 0.05);
  // The plant rests for a while first.
  record.input.head(5000).setZero();
  record.output = simulate(plant, record.input, record.step_s);
  const Model model = fit(record, integer(2, 0), {}).model;
  EXPECT_GT(model.validation->score.r2_percent, 99.99);
  const auto& denominator = model.transfer_function.denominator;
  EXPECT_NEAR(denominator[2].coefficient / denominator[0].coefficient / 1.9e5, 1.0, 1e-3);
}

TEST(Search, ReportsAnIntegratorThatWasMovingByItsBiasAndItsFirstOutput) {
  // A ball on a beam that is not level: a double integrator with an input bias and a first velocity.
  Model truth;
  truth.transfer_function = {{{7.0, 0.0}}, {{1.0, 2.0}, {1e-6, 1.0}, {1e-12, 0.0}}, 0.0};
  truth.input_bias = -0.02;
  truth.initial_output = -0.4;
  truth.initial_state = {0.3};
  for (const double delay_s : {0.0, 0.73}) {
    truth.transfer_function.delay_s = delay_s;
    const Record record = record_of(truth, 0.1, 600, 5, 1e-4);
    const double span = record.output.maxCoeff() - record.output.minCoeff();
    for (const int zeros : {0, 1}) {
      StructureOptions structure = integer(2, zeros);
      if (delay_s > 0.0) structure.structure.delay.freedom = Freedom::free;
      const Model model = fit(record, structure, {}).model;
      EXPECT_GT(model.estimation->score.r2_percent, 99.99) << delay_s << " s, " << zeros << " zeros";
      EXPECT_GT(model.validation->score.r2_percent, 99.9) << delay_s << " s, " << zeros << " zeros";
      EXPECT_NEAR(model.input_bias, -0.02, 0.002) << delay_s << " s, " << zeros << " zeros";
      EXPECT_NEAR(model.initial_output, record.output[0], 0.02 * span) << delay_s << " s, " << zeros << " zeros";
    }
  }
}

TEST(Search, TakesTheAliasBelowTheNyquistFrequency) {
  const Record record = record_of(arm(), 0.005, 1024, 1, 0.02);  // Nyquist 628 rad/s
  const Model model = fit(record, integer(6, 5), {}).model;
  const auto& d = model.transfer_function.denominator;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(6, 6);
  const double scale = 300.0;
  for (Eigen::Index k = 0; k < 6; ++k) {
    companion(0, k) = -d[static_cast<std::size_t>(k) + 1].coefficient / d[0].coefficient *
                      std::pow(scale, -static_cast<double>(k + 1));
    if (k < 5) companion(k + 1, k) = 1.0;
  }
  EXPECT_LT(companion.eigenvalues().imag().maxCoeff() * scale, pi / 0.005 * 1.001);
  EXPECT_GT(model.validation->score.r2_percent, 99.5);
}

/// Pairs of real poles over four decades.
std::vector<Eigen::VectorXd> real_poles(const Parametrisation& parametrisation) {
  std::vector<Eigen::VectorXd> starts;
  for (int i = 0; i < 20; ++i) {
    for (int k = 0; k <= i; ++k) {
      const auto pole = [](int n) { return std::complex<double>(-0.05 * std::pow(1.35, n), 0.0); };
      starts.push_back(parametrisation.at_poles({pole(i), pole(k)}, 0.0).value());
    }
  }
  return starts;
}

/// Two poles fitted to a record of a plant, from many starts.
struct TwoPolesFromAfar {
  explicit TwoPolesFromAfar(const Model& plant)
      : record(record_of(plant, 0.04, 1000, 12, 0.02)),
        prepared(record, {}),
        asked(integer(2, 0)),
        parametrisation(Parametrisation::search(asked, {40.0, record.step_s})),
        problem(prepared.compared({}), parametrisation, variant_at_rest(asked).linear),
        starts(real_poles(parametrisation)) {}

  [[nodiscard]] double least_cost() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Eigen::VectorXd& start : starts) least = std::min(least, minimise(problem, start).point.cost);
    return least;
  }

  Record record;
  PreparedRecord prepared;
  StructureOptions asked;
  Parametrisation parametrisation;
  OutputError problem;
  std::vector<Eigen::VectorXd> starts;
};

Model resonance() {
  Model plant;
  plant.transfer_function = {{{0.8, 0.0}}, {{1.0, 2.0}, {0.5, 1.0}, {25.0, 0.0}}, 0.0};
  return plant;
}

TEST(Polished, FindsTheBestOfManyStartsAlikeWithoutAWholeSearchFromEach) {
  const TwoPolesFromAfar fit(resonance());
  const SearchResult together = polished(fit.problem, fit.starts, Wanted::distinct, run_in_order);
  ASSERT_FALSE(together.optima.empty());
  EXPECT_LT(together.optima.front().point.cost, fit.least_cost() * (1.0 + 1e-6));
  EXPECT_LT(together.work.simulations(), 8 * fit.starts.size());
}

TEST(Polished, BeginsNoSearchOfPolesAtAStartThatCostsFarMoreThanOthers) {
  TwoPolesFromAfar fit(resonance());
  const std::complex<double> pole(-0.25, 4.98);
  fit.starts.push_back(fit.parametrisation.at_poles({pole, std::conj(pole)}, 0.0).value());
  const SearchResult together = polished(fit.problem, fit.starts, Wanted::distinct, run_in_order);
  ASSERT_FALSE(together.optima.empty());
  EXPECT_LT(together.optima.front().point.cost, fit.least_cost() * (1.0 + 1e-6));
  EXPECT_LT(together.work.local_searches, 10U);
}

TEST(Polished, EndsSearchesThatCannotOvertakeWhereTheBestOptimumAloneIsWanted) {
  Model plant;
  plant.transfer_function = {{{0.8, 0.0}}, {{0.3, 2.0}, {1.0, 1.0}, {0.6, 0.0}}, 0.0};
  StructureOptions asked = integer(2, 0);
  asked.structure = input_map_kinds().back().put_before(asked.structure);
  std::size_t of_all = 0;
  std::size_t of_one = 0;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Record record = record_of(plant, 0.04, 1000, seed, 0.1);
    const PreparedRecord prepared(record, {});
    const Parametrisation parametrisation =
        Parametrisation::search(asked, {40.0, record.step_s, record.input.minCoeff(), record.input.maxCoeff()});
    const OutputError problem(prepared.compared({false, true}), parametrisation,
                              variants(asked, 0, /*at_rest_before=*/false).back().linear);
    std::vector<Eigen::VectorXd> starts;
    for (const double pole : {0.4, 0.5, 0.6}) {
      for (const double map : {0.3, 0.4, 0.5, 0.6}) {
        Eigen::VectorXd& start = starts.emplace_back(parametrisation.start());
        for (Eigen::Index l = 0; l < start.size(); ++l) {
          const Coordinate& c = parametrisation.coordinates().at(static_cast<std::size_t>(l));
          start[l] = c.search_lower + (l < 2 ? pole : map) * (c.search_upper - c.search_lower);
        }
      }
    }
    const SearchResult all = polished(problem, starts, Wanted::distinct, run_in_order);
    const SearchResult one = polished(problem, starts, Wanted::best, run_in_order);
    ASSERT_FALSE(one.optima.empty());
    EXPECT_LT(one.optima.front().point.cost, all.optima.front().point.cost * (1.0 + 1e-6)) << "seed " << seed;
    of_all += all.work.simulations();
    of_one += one.work.simulations();
  }
  EXPECT_LT(10 * of_one, 9 * of_all);
}

TEST(Realisation, GuessesThePolesOfAnExactRecord) {
  const Record record = record_of(arm(), 0.002, 2000, 1, 0.0);
  const auto guesses = guess_poles(record, 2000, 4, false);
  ASSERT_FALSE(guesses.empty());
  double nearest = 1e300;
  for (const PoleGuess& guess : guesses) {
    double worst = 0.0;
    for (const std::complex<double>& pole :
         {std::complex<double>(-1.7, 183.992), std::complex<double>(-1.9, 397.995)}) {
      double distance = 1e300;
      for (const std::complex<double>& p : guess.poles) distance = std::min(distance, std::abs(p - pole));
      worst = std::max(worst, distance);
    }
    nearest = std::min(nearest, worst);
  }
  EXPECT_LT(nearest, 0.1);
}

TEST(Realisation, GuessesADelayFromTheQuietBeginning) {
  Model plant;
  plant.transfer_function = {{{2.0, 0.0}}, {{1.0, 2.0}, {3.0, 1.0}, {2.0, 0.0}}, 1.2};
  const Record record = record_of(plant, 0.1, 1000, 3, 0.01);
  const auto guesses = guess_poles(record, 1000, 2, true);
  EXPECT_TRUE(
      std::any_of(guesses.begin(), guesses.end(), [](const PoleGuess& g) { return std::abs(g.delay_s - 1.2) < 0.25; }));
}

TEST(Realisation, GuessesNothingFromAShortRecord) {
  EXPECT_TRUE(guess_poles(record_of(arm(), 0.002, 40, 1, 0.0), 40, 4, false).empty());
}

}  // namespace
}  // namespace eha::ident
