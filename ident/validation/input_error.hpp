// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/model/model.hpp"
#include "ident/model/model_output.hpp"

namespace eha::ident {

/// Returns the step that an input was rounded to, the least difference of two of its values [input unit]; 0 where it
/// stays at its value in most rows or has few values, as a command that is known exactly.
/// Cost O(N log N).
[[nodiscard]] double rounding_step(const Eigen::Ref<const Eigen::VectorXd>& input);

/// What the rounding of the recorded input leaves in the output of a plant that integrates, or nearly so: a walk, which
/// the autoregressive noise of the residual tests is too short for. The rounding is white, of variance q^2 / 12 with q
/// of rounding_step(), times the periods of an input that repeats, so a root of the walk's covariance is
///   q / sqrt(12) G c_k,  c_k = sqrt(2 / N) cos(pi k (n + 1/2) / N), k = 0, 1, ... (c_0 = sqrt(1 / N))
/// Columns end where their energy falls below a tenth of the noise's variance, or at 64; where the first has less than
/// three times that variance there are none.
/// @param first     first compared row wanted
/// @param residual  of the model at those rows and before or not; its differences give the noise
/// @returns rows by m; m is 0 where the model grows, the input is not rounded, or the walk is too small
/// Cost: a simulation a column.
[[nodiscard]] Eigen::MatrixXd rounding_walk(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                                            const Eigen::Ref<const Eigen::VectorXd>& residual);

/// What the noise of the input's channel leaves in the output of the model, as the plant got the levels of
/// held_levels() alone: G (u - levels) at the compared rows from `first` on.
/// @returns rows by 1; rows by 0 where the model grows or the input has no such levels, or no noise on them
/// Cost: a simulation.
[[nodiscard]] Eigen::MatrixXd channel_noise(const Model& model, OutputOnRecord& outputs, Eigen::Index first);

/// What a switch of the input may leave in the output that lies elsewhere in a gap than the straight line drawn across
/// it: for each gap of the record whose input is such a line G times a pulse there, of the standard deviation of a
/// switch at any of its rows, sqrt(p (1 - p)) of the change at the share p of the gap. It is as much smaller as a line
/// across one row errs less where the input was measured.
/// @param residual  as of rounding_walk(); the largest columns, at most 64, of more than a tenth of its noise
/// @returns rows by m; m is 0 where the model grows or no gap matters
/// Cost: a simulation a column.
[[nodiscard]] Eigen::MatrixXd guessed_switches(const Model& model, OutputOnRecord& outputs, Eigen::Index first,
                                               const Eigen::Ref<const Eigen::VectorXd>& residual);

}  // namespace eha::ident
