// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>

namespace eha::web {

/// The last 60 s of ehad's sample stream, with numbers that continue after a restart of ehad. Not thread-safe.
/// Memory: at most kMost blocks.
class LiveBlocks {
 public:
  static constexpr std::size_t kMost = 1600;  ///< 60 s of blocks of 40 ms, and some
  static constexpr std::int64_t kKept_ns = 60'000'000'000;

  /// @param samples  the member `samples` of an event, ehad-protocol(7); its lost blocks get numbers too
  /// @throws nlohmann::json::exception  not of that form
  void add(const nlohmann::ordered_json& samples);

  struct Part {
    std::int64_t first = 0;    ///< number of the first block
    std::int64_t next = 0;     ///< number to request next
    std::int64_t dropped = 0;  ///< missing blocks between the requested number and `next`
    std::string blocks;  ///< JSON: [[run_s, displacement_min_in, displacement_max_in, applied_min_V, applied_max_V,
                         ///< utc_ns], ...]
  };
  /// Returns the kept blocks from number `since` on. A number below 0, or one that this process has not given yet,
  /// means all kept blocks, with none dropped.
  [[nodiscard]] Part since(std::int64_t since) const;

 private:
  struct Block {
    std::int64_t number = 0;
    std::int64_t utc_ns = 0;
    std::string row;
  };
  std::deque<Block> blocks_;
  std::int64_t next_ = 0;
};

}  // namespace eha::web
