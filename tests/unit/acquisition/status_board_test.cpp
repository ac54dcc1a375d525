// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/status_board.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

namespace eha::acquisition {
namespace {

TEST(StatusBoard, NeverShowsAMixtureOfTwoSnapshots) {
  StatusBoard board;
  std::atomic<bool> ended{false};
  constexpr std::uint32_t kSnapshots = 100'000;
  std::thread writer([&] {
    for (std::uint32_t k = 1; k <= kSnapshots; ++k) {
      Snapshot snapshot;
      snapshot.sequence = k;
      snapshot.elapsed_ns = k;
      snapshot.displacement_in = k;
      snapshot.counters.ticks = k;
      snapshot.counters.involuntary_switches = k;
      board.publish(snapshot);
    }
    ended = true;
  });
  std::uint32_t last = 0;
  while (!ended) {
    const Snapshot seen = board.read();
    ASSERT_GE(seen.sequence, last);
    ASSERT_EQ(seen.elapsed_ns, seen.sequence);
    ASSERT_EQ(seen.displacement_in, seen.sequence);
    ASSERT_EQ(seen.counters.ticks, seen.sequence);
    ASSERT_EQ(seen.counters.involuntary_switches, seen.sequence);
    last = seen.sequence;
  }
  writer.join();
  EXPECT_EQ(board.read().sequence, kSnapshots);
}

}  // namespace
}  // namespace eha::acquisition
