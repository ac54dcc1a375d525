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

/// Tones that are taken from the reading of a controller while the rod moves steadily, forth and back: the valve stays
/// open on one side, so that neither dead band nor friction's turn is in what is measured. One fundamental, some of its
/// harmonics about the loop's crossover.
struct MarginSweep {
  static constexpr std::array<int, 6> kHarmonics{1, 2, 3, 5, 9, 16};
  static constexpr std::size_t kPeriods = 3;  ///< measured in each way

  std::size_t period_rows = 0;  ///< of the fundamental
  std::size_t lead_rows = 0;    ///< of a way, before the periods that are measured
  std::size_t ways = 0;         ///< even
  double speed = 0.0;           ///< of the rod between the tones [in/s]
  double tick_s = 0.0;
  std::array<double, kHarmonics.size()> amplitude{};  ///< [in]
  std::array<double, kHarmonics.size()> phase_rad{};

  [[nodiscard]] std::size_t rows() const noexcept { return ways * way_rows(); }
  [[nodiscard]] std::size_t way_rows() const noexcept { return lead_rows + measured_rows(); }
  [[nodiscard]] std::size_t measured_rows() const noexcept { return kPeriods * period_rows; }
  [[nodiscard]] double way() const noexcept { return speed * tick_s * static_cast<double>(way_rows()); }  ///< [in]
  /// What is taken from the reading, and so added to the error [in]. Real-time safe.
  [[nodiscard]] double injected(std::size_t row) const noexcept;
  [[nodiscard]] double fundamental_rad_s() const noexcept;
};

/// A sweep about the crossover of the loop with the plant that the settings were made for.
/// @param most_way    length of a way [in]
/// @param most_error  of the rod's motion about its way [in]
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

/// Margins of a loop as it was measured, with standard errors from the scatter of the ways (jackknife).
struct MeasuredMargins {
  /// ms and mt: the greatest from the lowest tone to the highest. The gain margin lies where the tones are weak, and is
  /// known to some 30 % only; ms / (ms - 1) bounds it from below.
  LoopMargins margins;
  double phase_std_deg = 0.0;
  double ms_std = 0.0;
  double mt_std = 0.0;
  double delay_std_s = 0.0;
  /// Of the plant, with the injection as the instrument, which no noise of the loop is in: gain over that of the
  /// settings' inverse, and lag with all delays from command to reading [s]. Student's t over the ways.
  SweptValue gain_share;
  SweptValue lag_s;
  std::vector<double> w_rad_s;                  ///< of the tones
  std::vector<std::complex<double>> open_loop;  ///< at the tones
};

/// The open loop L = H / (1 - H) from the closed one, H = rod over injection at each tone by least squares beside a
/// straight line, the mean over the ways. (The closed loop's phase is no margin.) The margins are those of a smooth
/// loop through the tones: L = C P exp(a - j b w - c w^2 + j d w^3), C the controller, P the plant that its
/// feed-forward knows; a to d by least squares, each tone by its accuracy.
/// @param ways  at least 2   @throws nothing
/// Cost: O(rows), some ms.
[[nodiscard]] MeasuredMargins measured_margins(const MarginSweep& sweep, const AxisSettings& settings,
                                               std::span<const SweepWay> ways);

}  // namespace eha::ident
