// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

/// The step of a record's coarse output where rounding to it makes much of what a model leaves over.
/// @param step      of the output, as SignalFacts::output_step()
/// @param output    of the record
/// @param every     rows over which each compared one is a mean
/// @param residual  at the compared rows
/// @returns none where rounding makes less than kShownByRounding of the residual's power
/// Cost O(N).
[[nodiscard]] std::optional<SensorStep> sensor_step(double step, const Eigen::VectorXd& output, int every,
                                                    const Eigen::VectorXd& residual);

/// From this share of the residual's power on rounding limits the answer.
inline constexpr double kShownByRounding = 0.3;

/// What rounding leaves of a coarse output while that rests at one value: not noise, but one error for all rows of the
/// stay. A root of its covariance: a column for each stay of 8 rows or more, at most the 64 longest, and of more
/// than 131072 rows as many as fit into 64 MiB, of the standard deviation of rounding, step / sqrt(12), less what noise
/// before the rounding takes away. A stay on a slow way has none: its errors cancel.
/// @param step   of the output, as SignalFacts::output_step()
/// @param first  first compared row wanted
/// @returns rows by m; m is 0 for an output without a step
/// Cost O(N) a column.
[[nodiscard]] Eigen::MatrixXd rounded_stays(const Record& record, double step, const Comparison& comparison,
                                            Eigen::Index first);

}  // namespace eha::ident
