// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

namespace eha::importer {

/// The value below which a share of the values lies, one of them. @param values  at least one  @param share  0 to 1
/// Cost O(N).
[[nodiscard]] double quantile(std::vector<double> values, double share);

/// Size and scale of a signal without its extremes.
struct Scale {
  double usual = 0.0;  ///< distance of a row from the middle of its neighbours, the median
  double range = 0.0;  ///< of the middle 98 %
  double step = 0.0;   ///< of a coarse signal, as ident::value_step(); 0: not coarse, or not asked for
};

/// @param values  those that are not finite are passed over; both sizes are 0 for fewer than three others. Cost O(N).
[[nodiscard]] Scale scale_of(std::span<const double> values);

}  // namespace eha::importer
