// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "ident/record.hpp"
#include "ident/valve/sheet_plan.hpp"

namespace eha::ident {

/// A value and half the width of its 95 % interval.
struct Measured {
  double value = 0.0;
  double half_width = 0.0;
};

/// One point of a frequency response, relative to the lowest frequency of its amplitude.
struct ResponsePoint {
  double frequency_Hz = 0.0;
  double gain_dB = 0.0;
  double phase_deg = 0.0;
  double gain_half_width_dB = 0.0;
  double phase_half_width_deg = 0.0;
};

/// The response of the rod's velocity to sines of one amplitude.
struct AmplitudeResponse {
  double percent = 0.0;                         ///< of half the command range
  double amplitude_V = 0.0;                     ///< [V]
  std::vector<ResponsePoint> points = {};       ///< none: not played, or every sine entered the dead band
  std::optional<Measured> minus_3dB_Hz = {};    ///< none: not observed up to the last point
  std::optional<Measured> minus_90deg_Hz = {};  ///< the same
  bool is_played = false;
};

/// Characteristics of a valve in the terms of ISO 10770-1, as far as they can be measured by the rod's motion.
struct ValveSheet {
  Measured null_V;                                    ///< middle of the dead band [V]
  Measured dead_band_V;                               ///< half width, by extending the straight flow curve to zero [V]
  Measured gain_positive_in_per_V_s;                  ///< velocity gain extending [in/(V s)]
  Measured gain_negative_in_per_V_s;                  ///< retracting, positive [in/(V s)]
  Measured hysteresis_V;                              ///< width between rising and falling command [V]
  bool has_hysteresis = false;                        ///< it exceeds its interval and the resolution of the method
  std::optional<Measured> creep_in_per_s = {};        ///< speed inside the dead band: load and leakage [in/s]
  double noise_in = 0.0;                              ///< standard deviation of the sensor at rest [in]
  double lag_s = 0.0;                                 ///< lag of the velocity behind the command [s]
  std::vector<AmplitudeResponse> responses = {};      ///< one for each of kSheetAmplitudes
  std::optional<Measured> natural_frequency_Hz = {};  ///< of the fitted second-order response; none: not observed
  std::optional<Measured> damping_ratio = {};
  double highest_Hz = 0.0;  ///< highest frequency of a measured sine [Hz]

  // For figures: the blocks of the triangles that give the static part.
  Eigen::VectorXd block_V = {};
  Eigen::VectorXd block_in_per_s = {};
};

/// Computes the valve sheet from the record of a plan. Velocity is the slope of the displacement in blocks of 0.2 s.
/// Outside the dead band, once the cylinder's pressures have settled after a reversal, it is
///   v = g+ (u - e+ - h s)  extending,   v = g- (u - e- - h s)  retracting,
/// s the sign of du/dt, u the command lag_s before: two linear least squares. null = (e+ + e-) / 2, dead band =
/// (e+ - e-) / 2. The sines give the response in amplitude and phase by linear least squares over whole periods;
/// 1/G = p0 + p1 s + p2 s^2 is fitted to them.
/// Intervals include the scatter of the residuals and the error of the method on simulated rigs (kMethod... in
/// static_sheet.cpp).
/// @param record  applied volts [V] and displacement [in], row 0 the plan's row 0; at least the rows of its triangles
/// @throws DataError  the rod hardly moved in one direction, or motion does not follow the command; says what to do
/// Cost: about 50 ms for 130 000 rows.
[[nodiscard]] ValveSheet valve_sheet(const Record& record, const SheetPlan& plan);

}  // namespace eha::ident
