// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>

namespace eha::identify {

/// Called before each step of long work, one at a time, in any of its threads.
/// @param share  done so far, 0..1
/// @param step   "fitting io"; one that ends with a line feed is a result, which stays on a terminal
using Progress = std::function<void(double share, const std::string& step)>;

/// Says once why a work goes on, in a line that stays on a terminal, and sets what its steps are for before each.
/// @param why   "no model passes its checks: all are fitted again from other starts"
/// @param what  "other starts"
[[nodiscard]] inline Progress progress_for(const std::string& why, const std::string& what, const Progress& progress) {
  if (!progress) return {};
  progress(0.0, why + "\n");
  return [what, progress](double share, const std::string& step) {
    progress(share, step.ends_with('\n') ? step : what + ": " + step);
  };
}

}  // namespace eha::identify
