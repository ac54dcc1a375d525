// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace eha::ident {

/// Duration of the measurement of a valve sheet on every rig [s].
inline constexpr double kSheetDuration_s = 130.0;

/// Amplitudes of the sines, as shares of half the command range.
inline constexpr std::array<double, 3> kSheetAmplitudes{0.05, 0.10, 0.25};

/// Prior knowledge of the valve.
struct ValveGuess {
  double null_V = 0.0;
  double edge_V = 0.0;                         ///< half width about the null beyond which the valve is surely open [V]
  std::optional<double> gain_in_per_V_s = {};  ///< the greater one; none: unknown
};

/// The part of the rig's limits that the measurement may use.
struct SheetLimits {
  double step_s = 0.001;
  double command_min_V = 0.0;
  double command_max_V = 0.0;
  double slew_V_per_s = 0.0;
  double travel_in = 0.0;  ///< between the travel limits [in]
};

/// A sine about a bias outside the dead band.
struct SineSegment {
  std::size_t level = 0;   ///< index into kSheetAmplitudes
  Eigen::Index first = 0;  ///< first measured row; the response settles before
  Eigen::Index rows = 0;   ///< whole periods
  double frequency_Hz = 0.0;
  double amplitude_V = 0.0;
  double bias_V = 0.0;  ///< above the guessed null when the rod extends, else below
};

/// Command of the measurement and positions of its parts: a rest, triangles through the null, sines on either side of
/// it.
struct SheetPlan {
  Eigen::VectorXd table_V;       ///< one voltage a tick [V]
  Eigen::Index rest_rows = 0;    ///< from row 0
  Eigen::Index sweep_first = 0;  ///< rows of the triangles
  Eigen::Index sweep_rows = 0;
  std::vector<SineSegment> sines = {};
  /// Highest frequency of each amplitude [Hz]; 0: not played, because of the slew limit, the range or the travel.
  std::array<double, kSheetAmplitudes.size()> highest_Hz{};
};

/// Plans the measurement of a valve sheet:
///   2 s at the null; 60 s of triangles of 0.3 of half the command range (more if the guess requires it), at most
///   20 s each and so fast that the rod moves a fifth of its travel at most; sines of three amplitudes, up to six
///   frequencies from 0.8 Hz to the frequency whose slew is 0.9 of the limit, each on a bias above and on one below the
///   dead band, so that the rod comes back; rest.
/// The same arguments give the same plan. Cost: some ms.
[[nodiscard]] SheetPlan sheet_plan(const SheetLimits& limits, const ValveGuess& guess);

}  // namespace eha::ident
