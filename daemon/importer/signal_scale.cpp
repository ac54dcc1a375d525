// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/signal_scale.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

namespace eha::importer {

double quantile(std::vector<double> values, double share) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

Scale scale_of(std::span<const double> values) {
  std::vector<double> finite;
  std::vector<double> off;
  finite.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite), [](double x) { return std::isfinite(x); });
  off.reserve(finite.size());
  for (std::size_t k = 1; k + 1 < finite.size(); ++k) {
    off.push_back(std::abs(finite[k] - 0.5 * (finite[k - 1] + finite[k + 1])));
  }
  if (off.empty()) return {};
  const double usual = quantile(std::move(off), 0.5);
  const double high = quantile(finite, 0.99);
  return {usual, high - quantile(std::move(finite), 0.01)};
}

}  // namespace eha::importer
