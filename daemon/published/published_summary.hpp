// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/published/published_study.hpp"

namespace eha::published {

/// One result of a test, of this program or a published one.
struct Line {
  double value = 0.0;  ///< [unit of the test]
  std::string method;
  std::string source;  ///< empty: this program
  bool is_ours = false;
};

/// Returns the published figures of a test and our score, the best first; a score that is not finite last.
[[nodiscard]] std::vector<Line> ranked(const StudiedSet& studied, const ScoredTest& scored);

/// "RMSE [mm] of 24821 rows", with its notes: "; these rows estimated the model", "; 5.09 with a start fitted to all of
/// them, which is no score".
[[nodiscard]] std::string heading(const ScoredTest& scored);

/// "integrator_lag (usable), recommended, estimated from 24841 rows in 6.9 s"
[[nodiscard]] std::string model_line(const StudiedSet& studied);

/// "DATA_EMPS.mat; from nonlinearbenchmark.org, EMPS", for a missing set.
[[nodiscard]] std::string absence(const StudiedSet& studied);

}  // namespace eha::published
