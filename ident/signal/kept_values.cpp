// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/kept_values.hpp"

#include <algorithm>
#include <limits>

namespace eha::ident {

void each_kept_value(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const std::function<void(Eigen::Index first, Eigen::Index last)>& take) {
  for (Eigen::Index first = 0; first < values.size();) {
    Eigen::Index end = first + 1;
    while (end < values.size() && is_same_value(values[end], values[first])) ++end;
    take(first, end - 1);
    first = end;
  }
}

bool stands_at_end(const Eigen::Ref<const Eigen::VectorXd>& values, double side) {
  constexpr double kLeastOverNext = 3.0;
  const Eigen::ArrayXd seen = side * values.array();
  const double end = seen.maxCoeff();
  double next = -std::numeric_limits<double>::infinity();
  for (const double value : seen) {
    if (!is_same_value(value, end)) next = std::max(next, value);
  }
  const auto rows_at = [&](double at) {
    return static_cast<double>(
        std::count_if(seen.begin(), seen.end(), [&](double value) { return is_same_value(value, at); }));
  };
  return rows_at(end) >= kLeastOverNext * rows_at(next);
}

}  // namespace eha::ident
