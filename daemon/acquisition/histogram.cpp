// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/histogram.hpp"

#include <cmath>

namespace eha::acquisition {

double Histogram::percentile_us(double share) const noexcept {
  if (count_ == 0) return 0.0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i + 1 < kBuckets; ++i) {
    seen += buckets_[i];
    if (seen >= wanted && seen > 0) return static_cast<double>(i + 1);
  }
  return static_cast<double>(maximum_ns_) / 1000.0;
}

}  // namespace eha::acquisition
