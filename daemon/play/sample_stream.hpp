// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <mutex>
#include <vector>

namespace eha::play {

/// Duration of a block of samples, the spacing of data_40ms.csv [ns].
inline constexpr std::int64_t kBlock_ns = 40'000'000;

/// Least and greatest of the samples of one block. NaN: nothing was measured, or nothing drives the rig.
struct SampleBlock {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::int64_t utc_ns = 0;  ///< time of day of its last sample, within one sample period [ns since 1970]
  double run_s = kNone;     ///< of its last sample, from the run's first tick [s]; NaN outside of a run
  double displacement_min_in = kNone;
  double displacement_max_in = kNone;
  double applied_min_V = kNone;
  double applied_max_V = kNone;
};

/// The last blocks of a rig's samples, numbered from 0, for readers that follow them. Thread-safe: a writer waits at
/// most for one copy of the kept blocks. Memory: kKept blocks, 12 KiB.
class SampleStream {
 public:
  static constexpr std::size_t kKept = 256;  ///< about 10 s

  void add(const SampleBlock& block);

  /// Returns the number of the next block.
  [[nodiscard]] std::uint64_t next() const;

  struct Part {
    std::uint64_t first = 0;  ///< number of the first block
    std::uint64_t lost = 0;   ///< requested, but no longer kept
    std::vector<SampleBlock> blocks;
  };
  /// Returns the kept blocks from `number` on. Cost: one copy of them.
  [[nodiscard]] Part since(std::uint64_t number) const;

 private:
  mutable std::mutex mutex_;
  std::array<SampleBlock, kKept> blocks_;
  std::uint64_t next_ = 0;
};

/// One sample of a rig.
struct Sample {
  std::int64_t time_ns = 0;  ///< never decreases between samples of one maker; in a run: from its first tick
  std::int64_t utc_ns = 0;
  double displacement_in = SampleBlock::kNone;
  double applied_V = SampleBlock::kNone;
};

/// Combines the samples of a run, or of a rig between runs, to blocks. Belongs to one thread.
class BlockMaker {
 public:
  enum class Kind { run, idle };
  BlockMaker(SampleStream& stream, Kind kind) : stream_(stream), kind_(kind) {}

  /// Adds a sample; one of a later block ends the present block. Allocates nothing.
  void add(const Sample& sample);
  /// Ends the present block.
  void finish();

 private:
  SampleStream& stream_;
  Kind kind_;
  std::int64_t number_ = -1;  ///< time of the block begun over kBlock_ns; -1: none
  SampleBlock block_;
};

}  // namespace eha::play
