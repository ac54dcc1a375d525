// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/residual_tests.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "ident/linear_algebra/spectra.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/statistics/distributions.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/output_derivatives.hpp"
#include "ident/validation/input_error.hpp"
#include "ident/validation/sensor_step.hpp"
#include "ident/validation/separated_noise.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kLags = 20;
constexpr double kDriftOverNoise = 3.0;
constexpr double kDriftOverError = 2.0;
constexpr Eigen::Index kFutureLags = 10;
constexpr double kTellsApart = 10.0;   // of BIC; Kass and Raftery, J. Am. Stat. Assoc. 90, 773 (1995): very strong
constexpr double kMostOfAll = 0.6;     // of the statistic of all kinds together: a plant of one kind has 0.73 and more
constexpr double kClearTrend = 1e-3;   // chance of a trend where there is none
constexpr double kLeastBeside = 1e-4;  // of the norm; a smaller rest is nearly a combination of other columns
constexpr double kEffectRank = 1e-3;   // weaker combinations explain noise
// Ratio of the errors of a model on two draws of the input: exceeded by 3 of 84 plants outside every structure.
constexpr double kOtherDraw = 1.5;
constexpr double kLeastMove = 0.02;  // of the input's range; less is noise of a measured input
constexpr double kLagRank = 1e-6;    // lags of a slow input are nearly collinear

Eigen::MatrixXd centred(const Eigen::MatrixXd& columns) { return columns.rowwise() - columns.colwise().mean(); }

double lagged_product(const Eigen::VectorXd& a, Eigen::Index lag) {
  return a.tail(a.size() - lag).dot(a.head(a.size() - lag));
}

ResidualTest judged(double statistic, Eigen::Index degrees) {
  ResidualTest test{statistic, static_cast<std::size_t>(degrees), 1.0};
  if (degrees > 0 && std::isfinite(statistic)) {
    test.p = chi_squared_share(std::max(0.0, statistic), static_cast<double>(degrees));
  }
  return test;
}

/// Returns an orthonormal basis of the columns, without those that are nearly combinations of others.
Eigen::MatrixXd basis_of(const Eigen::MatrixXd& columns) {
  const Eigen::VectorXd norms = columns.colwise().norm();
  if (columns.cols() == 0 || !(norms.maxCoeff() > 0.0)) return Eigen::MatrixXd(columns.rows(), 0);
  const ThinSvd svd = thin_svd(columns);
  return svd.left.leftCols((svd.values.array() > kLagRank * svd.values[0]).count());
}

/// Returns the columns' unit vectors orthogonal to a basis, without columns that lie in its span.
Eigen::MatrixXd beside(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& basis) {
  Eigen::MatrixXd left(columns.rows(), columns.cols());
  Eigen::Index count = 0;
  for (const auto& column : columns.colwise()) {
    const double norm = column.norm();
    if (!(norm > 0.0)) continue;
    const Eigen::VectorXd rest = column / norm - basis * (basis.transpose() * column / norm);
    if (rest.norm() > kLeastBeside) left.col(count++) = rest / rest.norm();
  }
  return left.leftCols(count);
}

/// Innovations with their variance and the effect of the parameters' errors.
struct Innovations {
  Eigen::VectorXd w;
  Eigen::MatrixXd error;    ///< a root of the covariance of the parameters' and the input's errors' effect
  Eigen::Index parameters;  ///< its columns of the parameters, the first
  double variance;          ///< of the noise
  double freedom;  ///< rows that the variance was estimated from, less the number of parameters estimated with it
};

/// Tests whether the innovations lie along an orthonormal basis more than noise and the parameters' errors explain.
ResidualTest test_along(const Innovations& of, const Eigen::MatrixXd& q) {
  if (q.cols() == 0 || !(of.variance > 0.0)) return {};
  const Eigen::MatrixXd seen = q.transpose() * of.error;
  Eigen::MatrixXd covariance = seen * seen.transpose();
  covariance.diagonal().array() += of.variance;
  const Eigen::VectorXd z = q.transpose() * of.w;
  ResidualTest test = judged(z.dot(covariance.llt().solve(z)), q.cols());
  const auto degrees = static_cast<double>(q.cols());
  if (std::isfinite(test.statistic) && of.freedom > 1.0) {
    test.p = fisher_share(std::max(0.0, test.statistic) / degrees, degrees, of.freedom);
  }
  return test;
}

/// Ljung and Box's test of innovations. @param unknown  as of SeparatedNoise, whitened
ResidualTest whiteness_test(const Eigen::VectorXd& w, const Eigen::MatrixXd& unknown, Eigen::Index order) {
  const auto n = static_cast<double>(w.size());
  const auto expected = [&](Eigen::Index lag) {
    double sum = lagged_product(w, lag);
    for (const auto& column : unknown.colwise()) sum += lagged_product(column, lag);
    return sum;
  };
  const double power = expected(0);
  if (!(power > 0.0)) return {};
  double sum = 0.0;
  for (Eigen::Index lag = 1; lag <= kLags; ++lag) {
    const double r = expected(lag) / power;
    sum += r * r / (n - static_cast<double>(lag));
  }
  return judged(n * (n + 2.0) * sum, kLags - order);
}

using Whiten = std::function<Eigen::MatrixXd(const Eigen::MatrixXd&)>;

/// Whether the residual is one of a gain that changes with the size of the input, beside what a linear plant and
/// effects that are alike for both signs of the input do. @param effects  of kind level, whitened
GainTrend gain_trend(const Innovations& of, const Eigen::MatrixXd& effects, const Eigen::MatrixXd& linear) {
  Eigen::MatrixXd others(linear.rows(), linear.cols() + 1);
  others << linear, effects.col(kEvenLevel);
  const Eigen::MatrixXd growing = beside(effects.col(kOddLevel), basis_of(others));
  if (growing.cols() == 0 || test_along(of, growing).p > kClearTrend) return GainTrend::unknown;
  return growing.col(0).dot(of.w) < 0.0 ? GainTrend::falls : GainTrend::grows;
}

/// @param past  an orthonormal basis of the input's lags, whose effect another test covers
NonlinearityTest nonlinearity_test(const TestedPart& part, const Innovations& innovations, const Eigen::MatrixXd& past,
                                   const Whiten& white) {
  NonlinearityTest found;
  double most = -std::numeric_limits<double>::infinity();
  double next = most;
  double named = 0.0;  // statistic of the kind that is named
  double drift = 0.0;  // of time
  NonlinearKind next_kind = found.kind;
  // A wrong model has wrong parameters; their errors would explain a part of level and position.
  Eigen::MatrixXd linear(past.rows(), past.cols() + innovations.parameters);
  linear << past, innovations.error.leftCols(innovations.parameters);
  const Eigen::MatrixXd linear_basis = basis_of(linear);
  Eigen::MatrixXd all(past.rows(), 0);
  for (const NonlinearEffects& effects : part.effects) {
    const Eigen::MatrixXd whitened = white(effects.columns);
    const Eigen::MatrixXd columns = beside(whitened, past);
    const ResidualTest one = test_along(innovations, basis_of(beside(columns, linear_basis)));
    // BIC of the effects of each kind; the p values of strong effects are all 0.
    const double gain = one.statistic - static_cast<double>(one.degrees) * std::log(innovations.freedom);
    if (effects.kind == NonlinearKind::time) {
      // A drift of few columns rivals any kind where the input happens to be another one later; it is one where it is
      // nearly all there is.
      drift = one.statistic;
    } else if (one.degrees > 0 && gain > most) {
      next = std::exchange(most, gain);
      next_kind = found.kind;
      found.kind = effects.kind;
      named = one.statistic;
      found.gain =
          effects.kind == NonlinearKind::level ? gain_trend(innovations, whitened, linear_basis) : GainTrend::unknown;
    }
    if (effects.kind != NonlinearKind::time && one.degrees > 0 && gain > next && effects.kind != found.kind) {
      next = gain;
      next_kind = effects.kind;
    }
    all.conservativeResize(Eigen::NoChange, all.cols() + columns.cols());
    all.rightCols(columns.cols()) = columns;
  }
  found.test = test_along(innovations, basis_of(all));
  if (drift > named && drift >= kMostOfAll * found.test.statistic) {
    found.kind = NonlinearKind::time;
    found.gain = GainTrend::unknown;
    return found;
  }
  const bool is_part = next > 0.0 && named < kMostOfAll * found.test.statistic;
  if (most - next < kTellsApart || is_part) found.or_kind = next_kind;
  return found;
}

/// The effects of the parameters' errors, then of the input's.
Eigen::MatrixXd all_errors(const TestedPart& part) {
  Eigen::MatrixXd errors(part.residual.size(), part.parameter_error.cols() + part.input_error.cols());
  errors.leftCols(part.parameter_error.cols()) = part.parameter_error;
  errors.rightCols(part.input_error.cols()) = part.input_error;
  return errors;
}

/// The input's lags and the nonlinear effects, each column of unit norm and without its mean.
Eigen::MatrixXd all_effects(const TestedPart& part) {
  Eigen::MatrixXd columns = centred(part.past_input);
  for (const NonlinearEffects& effects : part.effects) {
    columns.conservativeResize(Eigen::NoChange, columns.cols() + effects.columns.cols());
    columns.rightCols(effects.columns.cols()) = centred(effects.columns);
  }
  for (auto column : columns.colwise()) column /= std::max(column.norm(), std::numeric_limits<double>::min());
  return columns;
}

struct NoiseBesideEffects {
  Autoregression model;
  Eigen::Index effects = 0;  ///< independent ones
};

/// Estimates the noise's model together with the effects that the tests look for. Estimated alone, the noise model
/// would absorb an effect stronger than the noise itself, and hide it.
/// @param effects, e, error  with the filter's colour removed   @param start  the noise's model without effects
NoiseBesideEffects noise_beside_effects(const Eigen::MatrixXd& effects, const Eigen::VectorXd& e,
                                        const Eigen::MatrixXd& error, const Autoregression& start) {
  const ThinSvd svd = thin_svd(effects);
  const Eigen::Index rank = (svd.values.array() > kEffectRank * svd.values[0]).count();
  Eigen::MatrixXd known(e.size(), error.cols() + rank);
  // Any of these effects may cause the whole residual.
  known << error, e.norm() * svd.left.leftCols(rank);
  return {separated_noise(e, known, &start).model, rank};
}

/// @param columns  of all_effects()   @param whitened  the same   @param order  of the noise, 0: white
PredictedError predicted_error(const TestedPart& part, const Innovations& innovations, const Eigen::MatrixXd& columns,
                               const Eigen::MatrixXd& whitened, Eigen::Index order) {
  const ThinSvd svd = thin_svd(whitened);
  const Eigen::Index rank = (svd.values.array() > kEffectRank * svd.values[0]).count();
  const Eigen::MatrixXd made = columns * svd.right.leftCols(rank) * svd.values.head(rank).cwiseInverse().asDiagonal();
  const auto n = static_cast<double>(part.residual.size());
  const double all = centred(part.residual).squaredNorm() / n;
  const double of_noise = innovations.variance * made.squaredNorm() / n;
  const double found = (made * (svd.left.leftCols(rank).transpose() * innovations.w)).squaredNorm() / n - of_noise;
  const double effect = std::max(0.0, found);
  const double share = of_noise / std::max(1.0, static_cast<double>(rank));
  const double uncertain = 2.0 * std::sqrt(2.0 * share * of_noise + 4.0 * share * effect);
  const double parameters = part.parameter_error.squaredNorm() / n;
  const double most = order == 0 ? std::min(all, effect + uncertain + parameters) : all;
  const double scale = part.output_std > 0.0 ? 100.0 / part.output_std : 0.0;
  const double least = std::min(most, std::max(0.0, effect - uncertain));
  return {scale * std::sqrt(least) / kOtherDraw, scale * std::sqrt(most) * kOtherDraw};
}

ResidualDrift drift_of(const Eigen::VectorXd& e, const Eigen::MatrixXd& error) {
  const Eigen::VectorXd line = Eigen::VectorXd::LinSpaced(e.size(), -0.5, 0.5);
  const Eigen::VectorXd weights = line / line.squaredNorm();
  const double slope = weights.dot(e);
  const double left = std::sqrt((e - slope * line).squaredNorm() / static_cast<double>(e.size()));
  return {std::abs(slope), kDriftOverNoise * left + kDriftOverError * (error.transpose() * weights).norm()};
}

/// The rows of whose lags the input moves.
std::size_t moved_rows(const Eigen::MatrixXd& past_input) {
  if (past_input.size() == 0) return 0;
  const double least = kLeastMove * (past_input.maxCoeff() - past_input.minCoeff());
  const Eigen::ArrayXd covered = (past_input.rowwise().maxCoeff() - past_input.rowwise().minCoeff()).array();
  return static_cast<std::size_t>((covered > least).count());
}

}  // namespace

std::optional<ResidualTests> residual_tests(const TestedPart& part) {
  const Eigen::Index rows = part.residual.size() - kHighestAutoregression;
  if (rows < 3 * kLags) return {};
  const Eigen::VectorXd e = centred(part.residual);
  if (!(e.squaredNorm() > 0.0) || !e.allFinite()) return {};
  const auto unfiltered = [&](const Eigen::MatrixXd& columns) {
    return without_filter(centred(columns), part.filter_correlation);
  };
  const Eigen::VectorXd unfiltered_e = unfiltered(e);
  const Eigen::MatrixXd errors = all_errors(part);
  const Eigen::MatrixXd unfiltered_error = unfiltered(errors);
  const SeparatedNoise noise = separated_noise(unfiltered_e, unfiltered_error);
  ResidualTests tests;
  const Autoregression& tested = noise.tested;
  tests.ar_order = static_cast<std::size_t>(tested.coefficients.size());
  tests.whiteness = whiteness_test(centred(whitened(noise.clean, tested)), centred(whitened(noise.unknown, tested)),
                                   tested.coefficients.size());
  const Eigen::MatrixXd effects = all_effects(part);
  const Eigen::MatrixXd unfiltered_effects = without_filter(effects, part.filter_correlation);
  const NoiseBesideEffects beside_effects =
      noise_beside_effects(unfiltered_effects, unfiltered_e, unfiltered_error, noise.model);
  const Autoregression& model = beside_effects.model;
  const auto order = model.coefficients.size();
  const auto white = [&](const Eigen::MatrixXd& columns) { return centred(whitened(columns, model)); };
  const Whiten white_and_unfiltered = [&](const Eigen::MatrixXd& columns) { return white(unfiltered(columns)); };
  const auto n = static_cast<double>(model.samples);
  const double freedom = n - static_cast<double>(order) - 1.0;
  const Innovations innovations{white(unfiltered_e), white(unfiltered_error), part.parameter_error.cols(),
                                model.variance * n / std::max(1.0, freedom),
                                freedom - static_cast<double>(beside_effects.effects)};
  const Eigen::MatrixXd past = basis_of(white_and_unfiltered(part.past_input));
  tests.input = test_along(innovations, past);
  if (part.future_input.cols() > 0) {
    tests.future_input = test_along(innovations, basis_of(beside(white_and_unfiltered(part.future_input), past)));
  }
  if (!part.effects.empty()) {
    tests.nonlinearity = nonlinearity_test(part, innovations, past, white_and_unfiltered);
    tests.error = predicted_error(part, innovations, effects, white(unfiltered_effects), order);
  }
  tests.drift = drift_of(e, errors);
  tests.moved = moved_rows(part.past_input);
  const Eigen::VectorXd beyond = centred(beyond_errors(e, centred(errors)));
  tests.rms_beyond_errors = std::sqrt(beyond.squaredNorm() / static_cast<double>(beyond.size()));
  return tests;
}

TestedPart tested_part(const Model& model, OutputOnRecord& outputs, const SignalFacts& facts, std::size_t first,
                       const Eigen::VectorXd& residual, const ParameterCovariance& known, Effects effects) {
  TestedPart part;
  const Comparison& comparison = outputs.comparison();
  const auto begin = std::max(static_cast<Eigen::Index>(first), kLags);
  const Eigen::Index rows = static_cast<Eigen::Index>(comparison.count) - begin;
  if (rows < 1 || residual.size() < rows) return part;
  part.residual = residual.tail(rows);
  part.filter_correlation = filtered_noise_correlation(comparison);
  const Eigen::VectorXd input = picked(outputs.record().input, comparison);
  const Eigen::Index first_lag = least_input_lag(comparison);
  part.past_input.resize(rows, kLags + 1 - first_lag);
  for (Eigen::Index lag = first_lag; lag <= kLags; ++lag) {
    part.past_input.col(lag - first_lag) = input.segment(begin - lag, rows);
  }
  part.future_input.resize(rows, kFutureLags + first_lag);
  for (Eigen::Index ahead = 1 - first_lag; ahead <= kFutureLags; ++ahead) {
    // Beyond the record its last input is held.
    const Eigen::Index known_rows = std::max<Eigen::Index>(0, rows - ahead);
    auto column = part.future_input.col(ahead - 1 + first_lag);
    column.setConstant(input[input.size() - 1]);
    column.head(known_rows) = input.segment(begin + ahead, known_rows);
  }
  const Eigen::MatrixXd derivatives = output_derivatives(with_rising_terms(model), outputs, known).bottomRows(rows);
  // A model written by hand, or fitted by the paper's procedure, has no covariance.
  part.parameter_error =
      derivatives.cols() > 0 ? Eigen::MatrixXd(derivatives * covariance_root(known.matrix)) : derivatives;
  if (!part.parameter_error.allFinite()) part.parameter_error.resize(rows, 0);
  const Eigen::MatrixXd walk = input_walk(model, outputs, begin, residual, facts.input_error_std());
  const Eigen::MatrixXd noise = channel_noise(model, outputs, facts, begin);
  const Eigen::MatrixXd switches = guessed_switches(model, outputs, begin, residual);
  const Eigen::MatrixXd stays = rounded_stays(outputs.record(), facts.output_step(), comparison, begin);
  part.input_error.resize(rows, walk.cols() + noise.cols() + switches.cols() + stays.cols());
  part.input_error << walk, noise, switches, stays;
  // The lags are those of the record, whichever of its rows are left.
  const MeasuredRows kept = outputs.measured_rows().from(begin);
  part.residual = kept.of(part.residual);
  for (Eigen::MatrixXd* columns : {&part.past_input, &part.future_input, &part.parameter_error, &part.input_error}) {
    *columns = kept.of_columns(*columns);
  }
  if (effects == Effects::leave_out) return part;
  part.effects = nonlinear_effects(model, outputs, static_cast<std::size_t>(begin));
  for (NonlinearEffects& effects_of_kind : part.effects) {
    effects_of_kind.columns = kept.of_columns(effects_of_kind.columns);
  }
  const Eigen::VectorXd output = kept.of(picked(outputs.record().output, comparison).tail(rows));
  part.output_std = std::sqrt((output.array() - output.mean()).square().mean());
  return part;
}

}  // namespace eha::ident
