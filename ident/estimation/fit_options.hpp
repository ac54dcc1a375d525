// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "ident/structure/structure_options.hpp"

namespace eha::ident {

enum class Procedure { standard, paper };  ///< spelled "default" and "paper" in files

/// Where a fit starts.
enum class Search {
  global,  ///< anywhere in the structure's search box and at known models, then local
  known,   ///< at known models and guessed poles; anywhere where neither gives a model
  local,   ///< at the requested start values, nowhere else
};

/// Where the 95 % intervals come from.
enum class IntervalMethod {
  profile,   ///< the profile of the cost where it is no parabola; takes as long as a hundred local fits then
  straight,  ///< standard errors alone, where only the estimates are wanted
};

/// How a record is used.
struct FitOptions {
  Procedure procedure = Procedure::standard;
  Search search = Search::global;
  IntervalMethod intervals = IntervalMethod::profile;
  int decimation = 1;      ///< every how many samples model and data are compared
  double discard_s = 0.0;  ///< not compared, though simulated [s]
  double split = 0.5;      ///< share of the compared samples that estimates; 1 leaves no validation
  std::uint64_t seed = 1;
  /// The input before the first row, at which the plant is at rest [input unit]; none: 0, or what the record shows.
  /// Needed for a record whose input steps at its first row.
  std::optional<double> input_before = {};
};

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
