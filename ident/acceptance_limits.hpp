// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>

namespace eha::ident {

/// Limits that an accepted model must meet.
struct AcceptanceLimits {
  double min_validation_r2_percent = 90.0;
  double max_abs_error = std::numeric_limits<double>::infinity();  ///< [output unit]
  bool require_stable = true;
  double min_stability_margin_rad = 0.0;
  // Greatest standard errors of gain and phase in the usable band.
  double usable_gain_error_dB = 1.0;
  double usable_phase_error_deg = 10.0;
};

}  // namespace eha::ident
