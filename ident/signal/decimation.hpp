// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <vector>

namespace eha::ident {

/// Linear-phase (symmetric) anti-alias filter for keeping every `factor`-th sample: a Kaiser-windowed sinc with -6 dB
/// at the new Nyquist frequency, flat to 1e-6 below half of it and -120 dB above one and a half of it, unit gain at 0.
/// @returns 16 factor + 1 taps; empty for factor 1
/// Kaiser and Schafer, IEEE Trans. ASSP 28 (1980).
[[nodiscard]] std::vector<double> antialias_taps(std::size_t factor);

/// Number of rows in the discarded time at the start of a record: the first kept row is the first one at or after
/// discard_s. Cost O(1).
[[nodiscard]] inline std::size_t discarded_rows(double discard_s, double step_s) noexcept {
  // A quotient that exceeds a whole number by less than this counts as that number.
  constexpr double kRounding = 1e-9;
  return static_cast<std::size_t>(std::ceil(discard_s / step_s - kRounding));
}

/// The kept rows of a record: each multiple of `every` from `first` on; `first` is a multiple, too.
struct KeptRows {
  std::size_t first = 0;
  std::size_t every = 1;
  [[nodiscard]] bool keeps(std::size_t row) const noexcept { return row >= first && row % every == 0; }
};

/// Every `every`-th row after the discarded ones. Cost O(1).
[[nodiscard]] inline KeptRows keep_every(std::size_t every, std::size_t discard) noexcept {
  return {(discard + every - 1) / every * every, every};
}

/// Rows of a record that are compared with a model: first, first + every, ... The filter's window lies within the
/// record for each of them, so no sample depends on padding.
struct Comparison {
  std::size_t first = 0;
  std::size_t every = 1;
  std::size_t count = 0;
  std::vector<double> taps;  ///< symmetric; empty for none
};

/// The least lag [compared rows] at which the input may move the output: a row's input is applied after its output was
/// sampled, and a controller may have made it of that output. 0 where compared rows lie apart: the input there stands
/// for that of the rows before as well. Cost O(1).
[[nodiscard]] inline Eigen::Index least_input_lag(const Comparison& comparison) noexcept {
  return comparison.every == 1 ? 1 : 0;
}

/// @param discard  rows before this one are not compared
[[nodiscard]] Comparison compare_every(std::size_t samples, std::size_t every, std::size_t discard);

/// Returns the filtered rows: count values. Cost O(count taps).
[[nodiscard]] Eigen::VectorXd picked(const Eigen::Ref<const Eigen::VectorXd>& signal, const Comparison& comparison);

/// Autocovariance of white noise of variance 1 at the compared rows, behind the filter, at lags 0, 1, ..., 16; empty
/// without a filter.
[[nodiscard]] std::vector<double> filtered_noise_correlation(const Comparison& comparison);

}  // namespace eha::ident
