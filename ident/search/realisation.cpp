// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/search/realisation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr std::array<Eigen::Index, 6> kSpacings = {1, 2, 4, 8, 16, 32};
constexpr Eigen::Index kLongestRegression = 30;
constexpr Eigen::Index kRowsPerUnknown = 4;
constexpr Eigen::Index kHankel = 40;
constexpr double kRidge = 1e-10;                            // of the mean square regressor, against a flat record
constexpr std::array<double, 2> kQuietBelow = {0.05, 0.3};  // of the largest impulse response: still dead time
constexpr double kGuessedPoleDamping = 1e-4;                // of a guessed pole, over its magnitude

/// h[1..], the response to a unit pulse of one sample, of y[k] = sum a_i y[k-i] + sum b_i u[k-i] + c.
std::optional<Eigen::VectorXd> impulse_response(const Eigen::VectorXd& u, const Eigen::VectorXd& y) {
  const Eigen::Index rows = y.size();
  const Eigen::Index lags = std::min(kLongestRegression, rows / (2 * kRowsPerUnknown) - 1);
  if (lags < 4) return {};
  const Eigen::Index used = rows - lags;
  Eigen::MatrixXd regressors(used, 2 * lags);
  for (Eigen::Index i = 0; i < lags; ++i) {
    regressors.col(i) = y.segment(lags - 1 - i, used);
    regressors.col(lags + i) = u.segment(lags - 1 - i, used);
  }
  // Means removed: the constant c.
  regressors.rowwise() -= regressors.colwise().mean().eval();
  Eigen::VectorXd target = y.tail(used);
  target.array() -= target.mean();
  const Eigen::VectorXd scale = regressors.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  regressors = regressors * scale.asDiagonal();
  Eigen::MatrixXd normal = regressors.transpose() * regressors;
  normal.diagonal().array() += kRidge;
  const Eigen::VectorXd solved = scale.cwiseProduct(solve_symmetric(normal, regressors.transpose() * target));
  Eigen::VectorXd h = Eigen::VectorXd::Zero(4 * kHankel);
  for (Eigen::Index k = 0; k < h.size(); ++k) {
    if (k < lags) h[k] = solved[lags + k];
    for (Eigen::Index i = 0; i < std::min(lags, k); ++i) h[k] += solved[i] * h[k - 1 - i];
  }
  if (!h.allFinite() || h.cwiseAbs().maxCoeff() == 0.0) return {};
  return h;
}

/// Left singular vectors of the Hankel matrix of the impulse response from `first` on.
Eigen::MatrixXd observability(const Eigen::VectorXd& h, Eigen::Index first) {
  const Eigen::Index n = kHankel;
  return thin_svd(
             Eigen::MatrixXd::NullaryExpr(n + 1, n, [&](Eigen::Index i, Eigen::Index j) { return h[first + i + j]; }))
      .left;
}

/// Eigenvalues of the realisation of order `order`.
std::vector<Complex> realised(const Eigen::MatrixXd& singular_vectors, Eigen::Index order) {
  const Eigen::MatrixXd chosen = singular_vectors.leftCols(order);
  const Eigen::MatrixXd shift = solve_pivoted(chosen.topRows(kHankel), chosen.bottomRows(kHankel));
  const Eigen::VectorXcd poles = eigenvalues(shift);
  return {poles.begin(), poles.end()};
}

/// The stable pole with the nearest sampled image.
Complex continuous(Complex z, double step_s) {
  const double fastest = std::numbers::pi / step_s;
  if (z.imag() == 0.0 && z.real() <= 0.0) return -fastest;  // no real pole has a negative image
  Complex s = std::log(z) / step_s;
  if (std::abs(s) > fastest) s *= fastest / std::abs(s);
  const double damping = std::max(std::abs(s.real()), kGuessedPoleDamping * std::abs(s) + 1e-12 * fastest);
  return {-damping, s.imag()};
}

}  // namespace

ImpulseResponses::ImpulseResponses(const Record& record, std::size_t rows) {
  for (const Eigen::Index spacing : kSpacings) {
    const Eigen::Index blocks = static_cast<Eigen::Index>(rows) / spacing;
    if (blocks < 2 * kLongestRegression) break;
    Eigen::VectorXd u(blocks);
    Eigen::VectorXd y(blocks);
    for (Eigen::Index k = 0; k < blocks; ++k) {
      u[k] = record.input.segment(k * spacing, spacing).mean();
      y[k] = record.output[k * spacing];
    }
    auto h = impulse_response(u, y);
    if (!h) continue;
    Eigen::MatrixXd whole = observability(*h, 0);
    all_.push_back({record.step_s * static_cast<double>(spacing), std::move(*h), std::move(whole)});
  }
}

std::vector<PoleGuess> ImpulseResponses::poles(int poles, bool delay_free) const {
  std::vector<PoleGuess> guesses;
  for (const Response& response : all_) {
    const Eigen::VectorXd& h = response.h;
    std::vector<Eigen::Index> quiet = {0};
    for (const double share : kQuietBelow) {
      if (!delay_free) break;
      Eigen::Index first = 0;
      while (first < kHankel && std::abs(h[first]) < share * h.cwiseAbs().maxCoeff()) ++first;
      if (first != quiet.back()) quiet.push_back(first);
    }
    for (const Eigen::Index first : quiet) {
      PoleGuess guess;
      guess.delay_s = static_cast<double>(first) * response.step_s;
      const std::vector<Complex> images =
          first == 0 ? realised(response.observability, poles) : realised(observability(h, first), poles);
      for (const Complex& z : images) guess.poles.push_back(continuous(z, response.step_s));
      guesses.push_back(std::move(guess));
    }
  }
  return guesses;
}

std::vector<PoleGuess> guess_poles(const Record& record, std::size_t rows, int poles, bool delay_free) {
  return ImpulseResponses(record, rows).poles(poles, delay_free);
}

}  // namespace eha::ident
