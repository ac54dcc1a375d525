// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace eha::ident {

/// Whole periods of a record: rows first .. first + length count - 1.
struct Periods {
  std::size_t first = 0;
  std::size_t length = 0;  ///< samples of one period
  std::size_t count = 0;
};

/// Smallest number of samples that holds whole periods of every line.
/// @param lines_Hz  rising, above 0   @param step_s  [s]   @param longest  samples at which the search ends
/// @returns 0 if there is no such number up to `longest`, or no line
/// Cost O(lines longest lines_Hz[0] step_s).
[[nodiscard]] std::size_t common_period(const std::vector<double>& lines_Hz, double step_s, std::size_t longest);

/// Returns the last whole periods of a record after its first `discard` rows; the transient is smallest there.
/// @throws DataError  fewer than two of them: noise and drift cannot be separated from the response
[[nodiscard]] Periods last_periods(std::size_t samples, std::size_t length, std::size_t discard);

/// Decomposition of a signal: signal = mean period, repeated + drift + noise.
struct PeriodicSignal {
  Eigen::MatrixXd periods;  ///< length x count, drift removed
  Eigen::VectorXd mean;     ///< of the periods
  Eigen::VectorXd drift;    ///< length count samples, mean 0; zeros if it was kept
  /// Range of the drift over the periods, as of a creeping rod or a remaining transient.
  double drift_range = 0.0;
  bool drift_detected = false;      ///< by an F test at 99.9 %, noise taken as white
  double noise_std = 0.0;           ///< of one sample, from the spread between periods
  double signal_to_noise_dB = 0.0;  ///< power of the mean period about its mean, over noise_std^2
};

enum class Drift { keep, remove };

/// Averages a signal over its periods. With Drift::remove a polynomial of degree 2 in time is first estimated from the
/// differences between periods, in which the periodic part cancels. A slow exponential, a bias into an integrator or a
/// creeping rod then does not leak into the lines of the spectrum.
/// @param signal  finite, at least first + length count samples
/// @returns in the signal's unit
/// @throws DataError  the periods do not lie within the signal, or are fewer than two
/// Cost O(length count). Thread-safe.
/// Pintelon, Schoukens, System Identification: A Frequency Domain Approach, 2nd ed. (2012), sec. 2.5.
[[nodiscard]] PeriodicSignal average_periods(const Eigen::Ref<const Eigen::VectorXd>& signal, const Periods& periods,
                                             Drift drift);

}  // namespace eha::ident
