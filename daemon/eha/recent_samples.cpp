// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/recent_samples.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "core/display_unit.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

/// Columns of a block.
constexpr std::size_t kDisplacementMin = 2;
constexpr std::size_t kDisplacementMax = 3;
constexpr std::size_t kAppliedMin = 4;
constexpr std::size_t kAppliedMax = 5;

struct SampleRange {
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

/// NaN without a measured block.
SampleRange range_of(const std::deque<Json>& blocks, std::size_t low, std::size_t high) {
  SampleRange range;
  for (const Json& block : blocks) {
    if (!block.at(low).is_number() || !block.at(high).is_number()) continue;
    range.low = std::fmin(range.low, block.at(low).get<double>());
    range.high = std::fmax(range.high, block.at(high).get<double>());
  }
  return range;
}

}  // namespace

void RecentSamples::add(const Json& samples) {
  for (const Json& block : samples.at("blocks")) {
    blocks_.push_back(block);
    if (blocks_.size() > kKept) blocks_.pop_front();
  }
}

std::string RecentSamples::text(const DisplayUnit& unit) const {
  const SampleRange rod = range_of(blocks_, kDisplacementMin, kDisplacementMax);
  if (std::isnan(rod.low)) return "not read yet";
  const double factor = unit.factor("in");
  std::string text = fmt::format("{:.3f} to {:.3f} {}", factor * rod.low, factor * rod.high, unit.of("in"));
  const SampleRange volts = range_of(blocks_, kAppliedMin, kAppliedMax);
  if (!std::isnan(volts.low)) text += fmt::format(", {:+.2f} to {:+.2f} V", volts.low, volts.high);
  return text;
}

}  // namespace eha::cli
