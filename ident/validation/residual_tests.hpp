// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"
#include "ident/uncertainty/bode_curve.hpp"
#include "ident/validation/nonlinear_effects.hpp"
#include "ident/validation/signal_facts.hpp"

namespace eha::ident {

/// Below this probability the test of the residual with future input shows that a controller made the input.
inline constexpr double kFeedbackLevel = 0.001;

/// Part of a record that a model is tested on. All its rows are compared rows.
struct TestedPart {
  Eigen::VectorXd residual;          ///< n samples [output unit]
  Eigen::MatrixXd past_input;        ///< n by lags, the input at lags 1, 2, ... of each sample; at 0 too if decimated
  Eigen::MatrixXd parameter_error;   ///< n by p: derivatives by the parameters times a root of their covariance
  Eigen::MatrixXd input_error = {};  ///< n by m, as input_walk() and channel_noise(); empty: none
  std::vector<double> filter_correlation = {};  ///< as filtered_noise_correlation()
  Eigen::MatrixXd future_input = {};            ///< n by lags, the rest: lags (0,) -1, -2, ...; empty: not requested
  std::vector<NonlinearEffects> effects = {};   ///< empty: not requested
  double output_std = 0.0;                      ///< standard deviation of the output [output unit], needed with effects
};

/// Tests a residual e of a model whose parameters were estimated elsewhere, all lags at once. First undoes the
/// decimation filter's colouring of white noise, in e and in all other signals. Then e = J z + noise, with z the
/// parameters' errors of covariance P and the rounding of the recorded input; z and the noise's autoregressive model A
/// are estimated together. With w = A e, U and J the input's lags and the derivatives filtered alike, all without their
/// means, and Q an orthonormal basis of U:
///   input:     (Q'w)' (s^2 I + Q'J P J'Q)^-1 Q'w, rank(U) times an F of rank(U) and as many degrees of freedom as
///              rows less those of A and the mean are left;
///   whiteness: n (n + 2) sum_k r_k^2 / (n - k), k = 1..20, chi-squared with 20 less the order of A, which is three
///              above that of BIC; r_k is the autocorrelation of w less J times the mean of z given e, with what the
///              covariance of z given e adds.
///   future input: as input, with the lags down to -10 and what they have beside those of the input before;
///   nonlinearity: the same with the nonlinear effects.
/// For all tests but whiteness A is estimated together with unbounded coefficients of the input's lags and the effects:
/// a noise model of the whole residual would absorb a strong effect.
/// The predicted error is the part of e that a regression of w on the input's lags and the effects explains.
/// A line through e is a drift if it changes by more than three standard deviations of the rest of e and two of the
/// parameters' errors' effect; three hold for noise of a correlation time up to a 30th of the rows.
/// Behind a move of the input are the rows of whose lags the input covers more than 2 % of its range.
/// A correct model alarms at the nominal level for any autoregressive noise of order up to 10.
/// @returns nothing if there are not three samples for each lag
/// Bohlin, IEEE Trans. AC 16 (1971), for tests with the model's own covariance; Ljung and Box, Biometrika 65 (1978).
[[nodiscard]] std::optional<ResidualTests> residual_tests(const TestedPart& part);

/// Whether to test a part for nonlinear effects, which takes five simulations.
enum class Effects { leave_out, include };

/// Returns the part of a record from compared row `first` on, with the effect of the parameters' errors on the model
/// there, by differences of simulations. A difference's step is a hundredth of the standard error, at most 0.01 for an
/// order and 1 % of any other value. Cost: a simulation a parameter.
[[nodiscard]] TestedPart tested_part(const Model& model, OutputOnRecord& outputs, const SignalFacts& facts,
                                     std::size_t first, const Eigen::VectorXd& residual,
                                     const ParameterCovariance& known, Effects effects);

}  // namespace eha::ident
