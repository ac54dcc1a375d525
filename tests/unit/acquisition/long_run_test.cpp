// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <atomic>
#include <thread>
#include <vector>

#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

long peak_memory_kB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

TEST(LongRun, OfTwoHoursLosesNothingAndTakesNoMoreMemoryThanAShortOne) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "takes too long under a sanitizer";
#endif
  constexpr std::uint32_t kRows = 7'200'000;
  FakeRig rig;
  Play play;
  play.table_V = cosine(1000);
  play.repetitions = kRows / 1000;
  std::atomic<bool> ended{false};
  std::uint64_t rows = 0;
  std::uint64_t gaps = 0;
  std::thread consumer([&] {
    std::vector<TickRecord> batch(1024);
    for (;;) {
      const bool was_last = ended;
      const std::size_t count = play.queue->pop(batch.data(), batch.size());
      for (std::size_t k = 0; k < count; ++k) gaps += batch[k].sequence == rows++ ? 0 : 1;
      if (count == 0 && was_last) return;
      if (count == 0) std::this_thread::yield();
    }
  });
  play.machine.reset();
  play.machine.arm();
  const long before_kB = peak_memory_kB();
  TableSource source(play.table_V, play.repetitions);
  play.report = run(rig, play.machine, source, play.limits, play.realtime, NonRealtime::refuse, play.clock, *play.queue,
                    play.stop, play.board);
  ended = true;
  consumer.join();
  EXPECT_EQ(play.report.outcome, Outcome::completed);
  EXPECT_EQ(play.report.counters.experiment_rows, kRows);
  EXPECT_EQ(play.report.counters.dropped, 0u);
  EXPECT_EQ(rows, play.report.counters.ticks);
  EXPECT_EQ(gaps, 0u);
  // The records alone are 460 MB; what may grow are pages of the queue and the test rig's log touched for the first
  // time.
  EXPECT_LT(peak_memory_kB() - before_kB, 8'000);
}

}  // namespace
}  // namespace eha::acquisition
