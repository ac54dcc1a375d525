// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace eha::acquisition {

/// Counts a duration in buckets of 1 us, with its greatest value and the time of that. Real-time safe.
class Histogram {
 public:
  static constexpr std::size_t kBuckets = 1024;  ///< the last one counts all durations from 1023 us up

  /// @param duration_ns  negative counts as 0   @param at_ns  when, from the run's start
  void add(std::int64_t duration_ns, std::int64_t at_ns) noexcept {
    const std::int64_t duration = duration_ns < 0 ? 0 : duration_ns;
    const auto bucket = static_cast<std::size_t>(duration / 1000);
    ++buckets_[bucket < kBuckets ? bucket : kBuckets - 1];
    ++count_;
    if (count_ == 1 || duration > maximum_ns_) {
      maximum_ns_ = duration;
      maximum_at_ns_ = at_ns;
    }
  }

  [[nodiscard]] const std::array<std::uint32_t, kBuckets>& buckets() const noexcept { return buckets_; }
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }
  [[nodiscard]] std::int64_t maximum_ns() const noexcept { return maximum_ns_; }
  [[nodiscard]] std::int64_t maximum_at_ns() const noexcept { return maximum_at_ns_; }

  /// Upper edge [us] of the bucket that holds the given share (0..1) of all values; 0 when empty.
  [[nodiscard]] double percentile_us(double share) const noexcept;

 private:
  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  std::int64_t maximum_ns_ = 0;
  std::int64_t maximum_at_ns_ = 0;
};

}  // namespace eha::acquisition
