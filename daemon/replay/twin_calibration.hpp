// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "hal/sim/sim_options.hpp"
#include "ident/executor.hpp"

namespace eha::replay {

/// A parameter of the simulated rig to be fitted.
struct CalibrationRequest {
  std::string key;                                       ///< of twin_parameters()
  std::optional<std::pair<double, double>> bounds = {};  ///< none: a fifth to five times the value, a voltage +-5 V
};

/// A fitted parameter with its 95 % interval.
struct CalibratedParameter {
  std::string key;
  double before = 0.0;
  double value = 0.0;
  double std = 0.0;
  double half_width = 0.0;  ///< value +- half_width; the effect of halving the integration step is added
};

struct Calibration {
  hal::SimOptions options;  ///< fitted, the rod's first position too
  std::vector<CalibratedParameter> parameters;
  double rms_error_in = 0.0;  ///< over the compared means
  double noise_in = 0.0;      ///< the part of that which differs from mean to mean, as noise does [in]
  int iterations = 0;
  bool converged = false;
};

/// Duration of the means that are compared, after the discarded start.
inline constexpr double kMean_s = 0.02;
inline constexpr double kLeftOut_s = 0.5;

/// An error so many times its noise is not noise alone: something else of the rig differs, too.
inline constexpr double kMoreThanNoise = 2.0;

/// Greatest half width of a determined parameter's 95 % interval, as a share of its size.
inline constexpr double kWidestInterval = 0.5;

/// Fits parameters of the simulated rig, and the rod's first position, to a record by least squares
/// (Levenberg-Marquardt within bounds, Jacobian by forward differences). Intervals allow for a coloured residual:
/// ident::uncertainty().
/// @param start     plausible values; @param volts, measured_in  N rows spaced step_s
/// @throws UsageError  an unknown key, one requested twice, or bounds that exclude the value
/// @throws DataError   the record is shorter than 2 s, or does not determine a parameter: names each such one, with the
///                     parameter that it cannot be distinguished from, or alone if the record does not depend on it
/// Cost: about ten times as many simulations of the record as parameters.
[[nodiscard]] Calibration calibrate(const hal::SimOptions& start, const std::vector<CalibrationRequest>& requests,
                                    const Eigen::VectorXd& volts, const Eigen::VectorXd& measured_in, double step_s,
                                    const ident::Executor& executor = ident::run_in_order,
                                    const std::function<void(double rms_in, int iteration)>& progress = {});

}  // namespace eha::replay
