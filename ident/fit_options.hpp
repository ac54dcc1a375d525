// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>

namespace eha::ident {

enum class Procedure { standard, paper };  ///< spelled "default" and "paper" in files

/// Starts of a fit.
enum class Search {
  global,   ///< over the structure's whole search box and at known models, then locally
  known,    ///< at known models and guessed poles; over the search box if these give no model
  nearest,  ///< at the known model of least error alone, roughly: for a model that cannot be recommended
  local,    ///< at the requested start values, nowhere else
};

/// Source of the 95 % intervals.
enum class IntervalMethod {
  profile,   ///< profile of the cost where the cost is not a parabola; this takes as long as a hundred local fits
  straight,  ///< from standard errors alone, for callers that need only the estimates
};

/// Results that a fit computes.
enum class Reported {
  everything,
  estimation,  ///< not the Bode curve, the validation and the noise: of a model that may be completed later
  score,       ///< nor what the recorded input's own error adds to the intervals: of a model that only serves others
};

/// Options of a fit to one record.
struct FitOptions {
  Procedure procedure = Procedure::standard;
  Search search = Search::global;
  IntervalMethod intervals = IntervalMethod::profile;
  Reported reported = Reported::everything;
  int decimation = 1;      ///< model and data are compared at every Nth sample
  double discard_s = 0.0;  ///< not compared, though simulated [s]
  double split = 0.5;      ///< share of the compared samples that estimates; 1 leaves no validation
  std::uint64_t seed = 1;
  /// Input before the first row, with the plant at rest [input unit]; none: 0, or what the record shows. Needed for a
  /// record whose input steps at its first row.
  std::optional<double> input_before = {};
  /// Mean square error of the estimating part beyond which the model is not wanted: the search of a grey box gives up
  /// where it will not come below it, and one along a flat valley is short. None: whatever is found.
  std::optional<double> most_mse = {};
};

}  // namespace eha::ident
