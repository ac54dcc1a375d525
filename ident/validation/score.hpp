// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Scores a simulated output against a measured one, e = measured - simulated, with the mean of the scored part:
///   R2 = 100 (1 - sum e^2 / sum (y - mean y)^2),  fit = 100 (1 - |e| / |y - mean y|),  MSE = mean e^2.
/// For a constant measured part R2 and fit are 100 if the simulation equals it, else minus infinity.
/// @param measured, simulated  N >= 1 samples each [output unit]
/// @throws DataError  lengths differ or are 0
/// Cost O(N). Source: Ljung, System Identification, 2nd ed., sec. 16.4.
[[nodiscard]] Score score(const Eigen::Ref<const Eigen::VectorXd>& measured,
                          const Eigen::Ref<const Eigen::VectorXd>& simulated);

/// R2 of the faster motion: of measured and simulated output, each less its mean over the tenth of the samples about
/// each of them. It does not see an error that wanders slowly.
/// @returns nothing below 100 samples, or where the output has no such motion. Cost O(N).
[[nodiscard]] std::optional<double> r2_of_faster_percent(const Eigen::VectorXd& measured,
                                                         const Eigen::VectorXd& simulated);

}  // namespace eha::ident
