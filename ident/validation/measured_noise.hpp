// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "ident/signal/periods.hpp"

namespace eha::ident {

/// Returns the standard deviation of the differences between the periods of an output, after the anti-alias filter and
/// at every `decimation`th row, the rows that a model is compared at. Drift is removed; white and coloured noise are
/// both measured. Of three or more periods the record's first is left out: the plant's transient inflates the noise up
/// to 20 times.
/// @param output  N samples [output unit], at least periods.first + length count
/// @returns [output unit]; 0 if too few rows are left behind the filter
/// @throws DataError  as average_periods(). Cost O(N).
[[nodiscard]] double measured_noise(const Eigen::Ref<const Eigen::VectorXd>& output, const Periods& periods,
                                    int decimation);

}  // namespace eha::ident
