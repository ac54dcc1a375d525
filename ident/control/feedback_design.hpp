// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "ident/control/feedback.hpp"
#include "ident/control/loop_margins.hpp"

namespace eha::ident {

/// A plant by its response on a grid of frequencies; a sampled one by that of the held and sampled plant.
struct PlantResponse {
  std::vector<double> w_rad_s;                      ///< rising; see loop_margins()
  std::vector<std::complex<double>> response = {};  ///< one a frequency
  double order_at_zero = 0.0;                       ///< n of P ~ 1/s^n at 0; every other pole is stable
};

/// P on 600 frequencies, from where its phase and gain are those at 0 to where it is small.
[[nodiscard]] PlantResponse sampled_response(const std::function<std::complex<double>(double w_rad_s)>& plant,
                                             double low_rad_s, double high_rad_s, double order_at_zero,
                                             int points = 600);

/// What a feedback is searched under.
struct DesignLimits {
  double sensitivity = 1.4;  ///< greatest max(Ms, Mt)
  /// Limit on the noise of the command as a share of what is allowed, at most 1; none: unlimited. Must not fall with
  /// any gain.
  std::function<double(const Feedback&)> noise_share = {};
};

/// What is to be small after a step of load at the plant's input.
enum class DesignCriterion {
  integrated_error,  ///< 1/ki of an integrating feedback; 1/kp of one that does not integrate
  squared_error,     ///< integral of e^2 over time; needs an integrating loop
};

/// A feedback and what binds it.
struct FeedbackDesign {
  FeedbackKind kind = FeedbackKind::p;
  Feedback feedback;
  double sensitivity = 0.0;    ///< max(Ms, Mt) reached
  double noise_share = 0.0;    ///< reached; 0 without a limit
  double squared_error = 0.0;  ///< integral of e^2 after a unit step of load [e^2 s/w^2]; infinite where it stays
};

/// Searches the feedback of least error under the limits: bisection for the gain that the criterion names, Nelder and
/// Mead over the others from a fixed set of starts.
///   squared error = (1/pi) int |P / (1 + L) / w|^2 dw   (Parseval)
/// @param filter_s  of the measurement, kept
/// @returns none where no gain keeps the limits
/// Astroem, Panagopoulos and Haegglund, Automatica 34 (1998): greatest ki under a limit on the sensitivity.
/// Cost: about 1 ms (p), 0.05 s (pi), 0.3 s (pid), 1 s (fopid).
[[nodiscard]] std::optional<FeedbackDesign> design_feedback(
    FeedbackKind kind, const PlantResponse& plant, const DesignLimits& limits, double filter_s = 0.0,
    DesignCriterion criterion = DesignCriterion::integrated_error);

/// RMS error of a PID over that of a FOPID of the same margins and noise, from which on fractional orders are worth
/// their effort.
inline constexpr double kFractionalIsWorth = 1.07;

/// The open loop on the plant's grid.
[[nodiscard]] std::vector<std::complex<double>> open_loop(const PlantResponse& plant, const Feedback& feedback);
/// n of the open loop at 0.
[[nodiscard]] double order_at_zero(const PlantResponse& plant, const Feedback& feedback);
[[nodiscard]] double squared_load_error(const PlantResponse& plant, const Feedback& feedback);

}  // namespace eha::ident
