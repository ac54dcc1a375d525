// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/statistics/robust.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace eha::ident {

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

double robust_std(std::vector<double> values) {
  constexpr double kStdOfMedian = 1.4826;
  for (double& value : values) value = std::abs(value);
  return kStdOfMedian * median_of(std::move(values));
}

double scatter_of_rows(const Eigen::VectorXd& readings) {
  std::vector<double> second;
  for (Eigen::Index k = 1; k + 1 < readings.size(); ++k) {
    second.push_back(readings[k - 1] - 2.0 * readings[k] + readings[k + 1]);
  }
  return robust_std(std::move(second)) / std::sqrt(6.0);  // of white noise they have 1 + 4 + 1 times the variance
}

}  // namespace eha::ident
