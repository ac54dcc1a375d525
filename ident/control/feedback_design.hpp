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

/// A plant as its response on a grid of frequencies; for a sampled plant, the response with its hold.
struct PlantResponse {
  std::vector<double> w_rad_s;                      ///< rising; see loop_margins()
  std::vector<std::complex<double>> response = {};  ///< one a frequency
  double order_at_zero = 0.0;                       ///< n of P ~ 1/s^n at 0; every other pole is stable
};

/// Samples P at 600 frequencies, from where its phase and gain equal those at 0 to where it is small.
[[nodiscard]] PlantResponse sampled_response(const std::function<std::complex<double>(double w_rad_s)>& plant,
                                             double low_rad_s, double high_rad_s, double order_at_zero,
                                             int points = 600);

/// Limits of a feedback design.
struct DesignLimits {
  double sensitivity = 1.4;  ///< greatest max(Ms, Mt)
  /// Limit on the noise of the command as a share of what is allowed, at most 1; none: unlimited. Must not fall with
  /// any gain.
  std::function<double(const Feedback&)> noise_share = {};
};

/// Quantity that is minimised after a load step at the plant's input.
enum class DesignCriterion {
  integrated_error,  ///< 1/ki of an integrating feedback; 1/kp of one that does not integrate
  squared_error,     ///< integral of e^2 over time; needs an integrating loop
};

/// A feedback with the values that it reaches of the limited and minimised quantities.
struct FeedbackDesign {
  FeedbackKind kind = FeedbackKind::p;
  Feedback feedback;
  double sensitivity = 0.0;    ///< max(Ms, Mt) reached
  double noise_share = 0.0;    ///< reached; 0 without a limit
  double squared_error = 0.0;  ///< integral of e^2 after a unit step of load [e^2 s/w^2]; infinite if the error remains
};

/// Searches the feedback of least error under the limits: by bisection over the gain of the criterion, by Nelder and
/// Mead over the other parameters from a fixed set of starts.
///   squared error = (1/pi) int |P / (1 + L) / w|^2 dw   (Parseval)
/// @param filter_s  of the measurement, kept
/// @returns none where no gain keeps the limits
/// Astroem, Panagopoulos and Haegglund, Automatica 34 (1998): greatest ki under a limit on the sensitivity.
/// Cost: about 1 ms (p), 0.05 s (pi), 0.3 s (pid), 1 s (fopid).
[[nodiscard]] std::optional<FeedbackDesign> design_feedback(
    FeedbackKind kind, const PlantResponse& plant, const DesignLimits& limits, double filter_s = 0.0,
    DesignCriterion criterion = DesignCriterion::integrated_error);

/// Ratio of RMS errors, PID over FOPID of the same margins and noise, above which a FOPID is worth its effort.
inline constexpr double kFractionalIsWorth = 1.07;

/// The open loop on the plant's grid.
[[nodiscard]] std::vector<std::complex<double>> open_loop(const PlantResponse& plant, const Feedback& feedback);
/// n of the open loop at 0.
[[nodiscard]] double order_at_zero(const PlantResponse& plant, const Feedback& feedback);
[[nodiscard]] double squared_load_error(const PlantResponse& plant, const Feedback& feedback);

}  // namespace eha::ident
