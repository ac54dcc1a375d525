// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "ident/model/model.hpp"

namespace eha::ident {

/// The criteria of one fit; see InformationCriteria.
/// @param measured           compared samples that estimate [output unit], as many as residuals
/// @param effective_samples  for AIC, AICc, BIC and FPE
/// AR-BIC is infinite for up to 10 rows, which are too few.
[[nodiscard]] InformationCriteria information(const Eigen::VectorXd& residual, const Eigen::VectorXd& measured,
                                              std::size_t parameters, double effective_samples);

}  // namespace eha::ident
