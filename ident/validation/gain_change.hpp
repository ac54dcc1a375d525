// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

namespace eha::ident {

/// The output answers more, or less, from one time on.
struct GainChange {
  double time_s = 0.0;  ///< of the record, to a hundredth of its length
  double ratio = 1.0;   ///< gain behind it over that before
};

/// Finds one sudden change of a plant's gain, by the output of a model that knows none: from one time on the measured
/// output is another multiple of the model's, which explains what is left over far better than an offset, a drift and a
/// gain that drifts.
/// @param time_s, measured, simulated  N compared samples each
/// @returns none on fewer than 200 samples. Cost O(N)
[[nodiscard]] std::optional<GainChange> gain_change(const Eigen::VectorXd& time_s, const Eigen::VectorXd& measured,
                                                    const Eigen::VectorXd& simulated);

/// The multiple of a model's output, with an offset of its own, that is nearest to a measured one.
struct OtherGain {
  double ratio = 1.0;      ///< of that gain over the model's
  double rms_error = 0.0;  ///< beside it [output unit]
};

/// @param measured, simulated  N compared samples each, at least 2. Cost O(N)
[[nodiscard]] OtherGain other_gain(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated);

}  // namespace eha::ident
