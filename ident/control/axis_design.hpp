// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ident/control/axis_controller.hpp"
#include "ident/control/feedback_design.hpp"
#include "ident/control/sampled_plant.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// What the controller is to do best.
enum class AxisPurpose {
  track,  ///< follow references
  hold,   ///< stay in a place: a quieter command, slower feedback
};

/// A valve's numbers with their standard deviations.
struct ValveNumbers {
  double null = 0.0;           ///< [V]
  double dead_band = 0.0;      ///< half width [V]
  double gain_positive = 0.0;  ///< [in/(V s)]
  double gain_negative = 0.0;  ///< positive [in/(V s)]
  double null_std = 0.0;
  double dead_band_std = 0.0;
  double gain_std_share = 0.0;  ///< of each gain
};

/// The rig and what is wanted of it. Lengths in the model's output unit, here [in].
struct AxisTask {
  AxisPurpose purpose = AxisPurpose::track;
  double sensitivity = 1.4;  ///< greatest max(Ms, Mt) at the 95 % draw
  double tick_s = 0.001;
  double command_min = -5.0;
  double command_max = 5.0;
  double slew_per_s = 20.0;
  double lowest = 0.0;          ///< travel [in]
  double highest = 0.0;         ///< [in]
  double velocity_limit = 0.0;  ///< of the rig [in/s]
  double noise = 0.0;           ///< standard deviation of a reading [in]
  double lsb = 0.0;             ///< of a reading [in]
  /// Of the valve where the model has no map of it; its gains also where the model's are of another kind.
  std::optional<ValveNumbers> valve = {};
  bool valve_is_measured = false;  ///< by a valve sheet: it also takes the place of the model's map
  int draws = 200;
  std::uint64_t seed = 1;
};

/// A figure over the draws: its value for the model as it is, and its bounds.
struct Interval {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};
/// @param beyond  share of the values beyond each of the two bounds; infinite values stay
[[nodiscard]] Interval interval(double value, std::vector<double> draws, double beyond);

/// Margins over the draws of the model's parameters, of the map's gain and of the computing delay, 0 to 1 tick.
/// 95 % of the draws keep each bound: the greatest Ms is the one that the design was to stay below.
struct MarginIntervals {
  Interval ms;
  Interval mt;
  Interval phase_deg;
  Interval gain;
  Interval delay_s;
  double crossover_rad_s = 0.0;
  double stable_share = 0.0;  ///< of the draws
  double peak95 = 0.0;        ///< max(Ms, Mt) that 95 % of the draws stay below
};

/// The model as the feedback sees it.
struct AxisPlant {
  TransferFunction g;  ///< from speed that is asked for [in/s] to position [in]
  double order_at_zero = 0.0;
  InverseExpansion inverse;  ///< of g
  ValveNumbers valve;
  std::optional<ValveMap> replaced = {};  ///< the model's map, where the sheet has taken its place
  double rest = 0.0;                      ///< position at which a plant that does not integrate rests [in]
  std::vector<TransferFunction> draws;    ///< of g, by the covariance of the model's parameters
  double compared_step_s = 0.0;           ///< of the model's fit; 0: not known
  double unseen_delay_s = 0.0;  ///< standard deviation of the dead time that the draws have beside the model's
  bool has_covariance = false;  ///< false: 5 % of the gain and 10 % of the lag are assumed
  // Sampled at the tick, computing delay included: one tick for the model as it is, 0 to 1 tick for the draws.
  std::vector<double> grid_rad_s;
  std::vector<std::complex<double>> response;
  std::vector<std::vector<std::complex<double>>> drawn_responses;
};

/// A linear design and what it rests on.
struct AxisDesign {
  AxisSettings settings;
  FeedbackDesign feedback;
  MarginIntervals margins = {};
  bool noise_binds = false;  ///< before the margin
};

/// @throws DataError  the model cannot be controlled: it grows, its gain at standstill is 0, its unit is not V to a
///                    length, or it does not move with its input
[[nodiscard]] AxisPlant axis_plant(const Model& model, const AxisTask& task);

/// Bounds of the reference that valve, slew and rig allow.
[[nodiscard]] ReferenceLimits reference_limits(const AxisPlant& plant, const AxisTask& task);

/// Feedback of one kind under the limits on margins and noise, with the measurement filter that gives the least error,
/// and all that belongs to it.
/// @returns none where no gain keeps the limits
[[nodiscard]] std::optional<AxisDesign> design_axis(const AxisPlant& plant, const AxisTask& task, FeedbackKind kind);
/// The same design with less gain: kp, ki and kd times `share`; smoothing and margins follow.
[[nodiscard]] AxisDesign with_share(const AxisDesign& design, const AxisPlant& plant, const AxisTask& task,
                                    double share);

/// RMS error after a load with the best PID over that with the best FOPID, both with the filter of `pid`, its margin
/// and the limit on noise. Cost: about 0.5 s.
[[nodiscard]] double gain_of_fractional_orders(const AxisPlant& plant, const AxisTask& task, const AxisDesign& pid);

/// RMS of the command caused by the noise of the readings, and of its change in a tick, the rod held [V].
struct CommandNoise {
  double rms = 0.0;
  double change_rms = 0.0;
};
[[nodiscard]] CommandNoise command_noise(const AxisSettings& settings, double noise);

/// Margins of the sampled loop for the model and its draws. Cost: about 5 ms.
[[nodiscard]] MarginIntervals margin_intervals(const AxisSettings& settings, const AxisPlant& plant);

}  // namespace eha::ident
