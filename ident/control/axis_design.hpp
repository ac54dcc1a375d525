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

/// Goal of the controller design.
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

/// The rig and the requirements on the controller. Lengths are in the model's output unit, here [in].
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
  /// Numbers of the valve, for a model without a valve map.
  std::optional<ValveNumbers> valve = {};
  bool valve_is_measured = false;  ///< by a valve sheet, or the map is doubtful; `valve` then replaces the map too
  int draws = 200;
  std::uint64_t seed = 1;
};

/// A quantity over the draws: its value for the undrawn model, and its bounds.
struct Interval {
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};
/// @param beyond  share of the values beyond each of the two bounds; infinite values are kept
[[nodiscard]] Interval interval(double value, std::vector<double> draws, double beyond);

/// Margins over the draws of the model's parameters, of the map's gain and of the computing delay (0 to 1 tick).
/// 95 % of the draws keep each bound. The upper bound of Ms is the one that the design limits.
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

/// Plant model of the feedback design.
struct AxisPlant {
  TransferFunction g;  ///< from the requested speed [in/s] to the position [in]
  double order_at_zero = 0.0;
  InverseExpansion inverse;  ///< of g
  ValveNumbers valve;
  std::optional<ValveMap> replaced = {};  ///< the model's map, if the valve sheet has replaced it
  double rest = 0.0;                      ///< rest position of a plant that does not integrate [in]
  std::vector<TransferFunction> draws;    ///< of g, by the covariance of the model's parameters
  double compared_step_s = 0.0;           ///< of the model's fit; 0: not known
  double unseen_delay_s = 0.0;            ///< standard deviation of the dead time that the draws add to the model's
  bool has_covariance = false;            ///< false: 5 % of the gain and 10 % of the lag are assumed
  // Sampled at the tick, computing delay included: one tick for the undrawn model, 0 to 1 tick for the draws.
  std::vector<double> grid_rad_s;
  std::vector<std::complex<double>> response;
  std::vector<std::vector<std::complex<double>>> drawn_responses;
};

/// A controller with its feedback design and margins.
struct AxisDesign {
  AxisSettings settings;
  FeedbackDesign feedback;
  MarginIntervals margins = {};
  bool noise_binds = false;  ///< the limit on noise binds before the limit on the margins
};

/// @throws DataError  the model cannot be controlled: it grows, its gain at standstill is 0, its unit is not V to a
///                    length, or it does not move with its input
[[nodiscard]] AxisPlant axis_plant(const Model& model, const AxisTask& task);

/// Returns the bounds of the reference that valve, slew limit and rig allow.
[[nodiscard]] ReferenceLimits reference_limits(const AxisPlant& plant, const AxisTask& task);

/// Designs a feedback of one kind under the limits on margins and noise, with the measurement filter of least error.
/// @returns none if no gain keeps the limits
[[nodiscard]] std::optional<AxisDesign> design_axis(const AxisPlant& plant, const AxisTask& task, FeedbackKind kind);
/// Returns the design with kp, ki and kd times `share`; adapts smoothing and margins.
[[nodiscard]] AxisDesign with_share(const AxisDesign& design, const AxisPlant& plant, const AxisTask& task,
                                    double share);

/// Returns the RMS error after a load step with the best PID over that with the best FOPID. Both have the measurement
/// filter, the margin and the noise limit of `pid`. Cost: about 0.5 s.
[[nodiscard]] double gain_of_fractional_orders(const AxisPlant& plant, const AxisTask& task, const AxisDesign& pid);

/// RMS of the command due to the noise of the readings, and of its change in a tick, with the rod at rest [V].
struct CommandNoise {
  double rms = 0.0;
  double change_rms = 0.0;
};
[[nodiscard]] CommandNoise command_noise(const AxisSettings& settings, double noise);

/// Margins of the sampled loop for the model and its draws. Cost: about 5 ms.
[[nodiscard]] MarginIntervals margin_intervals(const AxisSettings& settings, const AxisPlant& plant);

}  // namespace eha::ident
