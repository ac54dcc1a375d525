// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"
#include "ident/validation/signal_facts.hpp"

namespace eha::ident {

/// Returns the step that an input was rounded to, the least difference of two of its values [input unit]; 0 where it
/// stays at its value in most rows or has few values, as a command that is known exactly.
/// Cost O(N log N).
[[nodiscard]] double rounding_step(const Eigen::Ref<const Eigen::VectorXd>& input);

/// Returns the standard deviation of the white noise that a recorded signal has in itself [its unit]: of one that is
/// held, from the differences within its levels; of a smooth one, from its fourth and sixth differences, which must
/// agree. 0 where there is none to be seen, and of a signal as rough as noise. Cost O(N).
[[nodiscard]] double white_noise(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// The same of an input as rough as its noise, too, up to 0.72 of its spread: excitation that is rough in itself
/// has no flat spectrum towards the highest frequencies. Only what a plant makes of the input tells whether it is noise
/// of the measurement. Cost O(N log N).
[[nodiscard]] double apparent_input_noise(const Eigen::Ref<const Eigen::VectorXd>& input);

/// Returns the standard deviation of the white error of the recorded input as a walk sees it [input unit]: of
/// white_noise() or, where greater, of the rounding, q sqrt(P / 12) with q of rounding_step(), of an input that repeats
/// P times. Cost O(N log N).
[[nodiscard]] double input_error_std(const Eigen::Ref<const Eigen::VectorXd>& input);

/// What a white error of the recorded input leaves in the output of a plant that integrates, or nearly so: a walk,
/// which the autoregressive noise of residual tests and intervals is too short for. A root of its covariance is
///   sigma G c_k,  c_k = sqrt(2 / N) cos(pi k (n + 1/2) / N), k = 0, 1, ... (c_0 = sqrt(1 / N))
/// Columns end where their energy falls below a tenth of the noise's variance, or at 64; where the first has less than
/// three times that variance there are none.
/// @param first      first compared row wanted
/// @param residual   of the model at those rows or the measured ones of them; its differences give the noise
/// @param error_std  sigma, of input_error_std()
/// @returns rows by m; m is 0 where the model grows, sigma is 0, or the walk is too small
/// Cost: a simulation a column.
[[nodiscard]] Eigen::MatrixXd input_walk(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                                         const Eigen::Ref<const Eigen::VectorXd>& residual, double error_std);

/// A residual e less the part that known errors explain: W z with the most probable z of N(0, I) beside white noise,
/// shortened to a length of sqrt(m) + 3, which a sound z hardly exceeds. What is left shows how well a model describes
/// the plant. Cost O(N m^2).
/// @param errors  W, a root of the errors' covariance in the output, as input_walk(): N by m, or without columns
[[nodiscard]] Eigen::VectorXd beyond_errors(const Eigen::VectorXd& residual, const Eigen::MatrixXd& errors);

/// What the noise of the input's channel leaves in the output of the model, as the plant got the levels of
/// held_levels() alone: G (u - levels) at the compared rows from `first` on.
/// @returns rows by 1; rows by 0 where the model grows or the input has no such levels, or no noise on them
/// Cost: a simulation.
[[nodiscard]] Eigen::MatrixXd channel_noise(const Model& model, OutputOnRecord& outputs, const SignalFacts& facts,
                                            Eigen::Index first);

/// Noise of the recorded input that did not reach the plant: what the model makes of such noise has about the power
/// that the model leaves over, of changes over 1/50 of the rows. Where the noise reached the plant, the model leaves
/// far less over.
/// @param residual  of all compared rows, or the measured ones
/// @returns none where the input has no such noise, it makes less than 40 % of the residual's power or far more
/// than all of it, or the model grows
/// Cost: three simulations of an input that has noise.
[[nodiscard]] std::optional<InputNoise> input_noise_left_over(const Model& model, OutputOnRecord& outputs,
                                                              const SignalFacts& facts,
                                                              const Eigen::VectorXd& residual);

/// What cubics through the rows of an input that is taken as straight between them change of the model's output, rms
/// [output unit]. A signal that was sampled lies nearer to them than to the lines.
/// @returns none of an input that is held, or where the model grows. Cost: a simulation.
[[nodiscard]] std::optional<double> curves_between_rows(const Model& model, OutputOnRecord& outputs);

/// What a switch of the input may leave in the output that lies elsewhere in a gap than the straight line drawn across
/// it: for each gap of the record whose input is such a line G times a pulse there, of the standard deviation of a
/// switch at any of its rows, sqrt(p (1 - p)) of the change at the share p of the gap. It is as much smaller as a line
/// across one row errs less where the input was measured.
/// @param residual  as of input_walk(); the largest columns, at most 64, of more than a tenth of its noise
/// @returns rows by m; m is 0 where the model grows or no gap matters
/// Cost: a simulation a column.
[[nodiscard]] Eigen::MatrixXd guessed_switches(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                                               const Eigen::Ref<const Eigen::VectorXd>& residual);

}  // namespace eha::ident
