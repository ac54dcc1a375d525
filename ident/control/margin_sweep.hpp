// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "ident/control/axis_controller.hpp"
#include "ident/control/loop_margins.hpp"

namespace eha::ident {

/// Multisine that is subtracted from the controller's reading while the rod moves steadily to and fro. The valve stays
/// open on one side, so that neither the dead band nor a reversal of friction disturbs the measurement. The tones are
/// one fundamental and some of its harmonics about the loop's crossover.
struct MarginSweep {
  static constexpr std::array<int, 6> kHarmonics{1, 2, 3, 5, 9, 16};
  static constexpr std::size_t kPeriods = 3;  ///< periods measured in each way

  std::size_t period_rows = 0;  ///< of the fundamental
  std::size_t lead_rows = 0;    ///< of a way, before the measured periods
  std::size_t ways = 0;         ///< even
  double speed = 0.0;           ///< mean speed of the rod [in/s]
  double tick_s = 0.0;
  std::array<double, kHarmonics.size()> amplitude{};  ///< [in]
  std::array<double, kHarmonics.size()> phase_rad{};

  [[nodiscard]] std::size_t rows() const noexcept { return ways * way_rows(); }
  [[nodiscard]] std::size_t way_rows() const noexcept { return lead_rows + measured_rows(); }
  [[nodiscard]] std::size_t measured_rows() const noexcept { return kPeriods * period_rows; }
  [[nodiscard]] double way() const noexcept { return speed * tick_s * static_cast<double>(way_rows()); }  ///< [in]
  /// Returns the value that is subtracted from the reading, and thus added to the error [in]. Real-time safe.
  [[nodiscard]] double injected(std::size_t row) const noexcept;
  [[nodiscard]] double fundamental_rad_s() const noexcept;
};

/// Designs a sweep about the crossover of the loop with the plant that the settings were designed for.
/// @param most_way    length of a way [in]
/// @param most_error  greatest deviation of the rod from its way [in]
[[nodiscard]] MarginSweep margin_sweep(const AxisSettings& settings, double most_way, double most_error);

/// The measured periods of a way.
struct SweepWay {
  std::span<const double> injected;
  std::span<const double> rod;
};

/// A quantity with half of its 95 % interval.
struct SweptValue {
  double value = 0.0;
  double half_width = 0.0;
};

/// Measured margins of a loop, with standard errors from the scatter of the ways (jackknife).
struct MeasuredMargins {
  /// ms and mt are the greatest values from the lowest tone to the highest. The gain margin is accurate to about 30 %
  /// only, because the tones are weak there; ms / (ms - 1) bounds it from below.
  LoopMargins margins;
  double phase_std_deg = 0.0;
  double ms_std = 0.0;
  double mt_std = 0.0;
  double delay_std_s = 0.0;
  /// Gain of the plant over that of the settings' inverse, and the plant's lag with all delays from command to reading
  /// [s]. The injection serves as instrument, so that the noise of the loop adds no bias. Student's t over the ways.
  SweptValue gain_share;
  SweptValue lag_s;
  std::vector<double> w_rad_s;                  ///< of the tones
  std::vector<std::complex<double>> open_loop;  ///< at the tones
};

/// Estimates the open loop L = H / (1 - H) from the closed loop H. H is rod over injection at each tone, by least
/// squares beside a straight line, the mean over the ways. (The closed loop's phase is not a margin.) The margins are
/// those of a smooth loop through the tones: L = C P exp(a - j b w - c w^2 + j d w^3), with C the controller and P the
/// plant of the feed-forward. a to d follow by least squares, each tone weighted by its accuracy.
/// @param ways  at least 2   @throws nothing
/// Cost: O(rows), some ms.
[[nodiscard]] MeasuredMargins measured_margins(const MarginSweep& sweep, const AxisSettings& settings,
                                               std::span<const SweepWay> ways);

}  // namespace eha::ident
