// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/known_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

namespace eha::report {
namespace {

using plot::Series;

bool has_finite(const Series& series) {
  return std::any_of(series.y.begin(), series.y.end(), [](double y) { return std::isfinite(y); });
}

}  // namespace

void add_known_line(plot::Panel& panel, const std::string& label, const ReportedModel& reported,
                    const std::vector<double>& frequency_Hz, const std::vector<double>& values, int style) {
  constexpr double kRounding = 1e-6;
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  const std::optional<ident::FrequencyInterval> usable = reported.usable_band();
  const auto is_known = [&](std::size_t i) {
    if (!usable) return !reported.model.verdict;
    return frequency_Hz[i] >= usable->lowest_Hz * (1.0 - kRounding) &&
           frequency_Hz[i] <= usable->highest_Hz * (1.0 + kRounding);
  };
  Series known{.label = label, .x = frequency_Hz, .y = values, .style = style};
  Series beyond{.label = "", .x = frequency_Hz, .y = values, .style = style, .is_faint = true};
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!is_known(i)) {
      known.y[i] = kGap;
      continue;
    }
    const bool is_end = (i > 0 && !is_known(i - 1)) || (i + 1 < values.size() && !is_known(i + 1));
    if (!is_end) beyond.y[i] = kGap;  // the two lines meet at the ends of the band
  }
  const bool is_listed = !label.empty();
  if (!has_finite(known)) {
    beyond.label = is_listed ? label + ", no usable band" : "";
    panel.series.push_back(std::move(beyond));
    return;
  }
  panel.series.push_back(std::move(known));
  if (!has_finite(beyond)) return;
  const bool is_first = std::none_of(panel.series.begin(), panel.series.end(),
                                     [](const Series& series) { return series.is_faint && !series.label.empty(); });
  if (is_listed && is_first) beyond.label = "outside the usable band";
  panel.series.push_back(std::move(beyond));
}

}  // namespace eha::report
