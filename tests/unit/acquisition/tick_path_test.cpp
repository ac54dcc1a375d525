// SPDX-License-Identifier: GPL-3.0-or-later
// The tick path must not allocate, lock or take a page fault.
#include <gtest/gtest.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "daemon/acquisition/loop.hpp"
#include "daemon/acquisition/realtime.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "daemon/place/hold_source.hpp"
#include "daemon/place/place_source.hpp"
#include "daemon/track/track_source.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"
#include "tests/unit/acquisition/tracked.hpp"
#include "tests/unit/acquisition/trap.hpp"

namespace eha::acquisition {
namespace {

/// Plays a run with the trap set around the loop. @returns allocations and locks seen in it
std::pair<long, long> trapped_run(Play& play, hal::Rig& rig, CommandSource& source) {
  play.machine.reset();
  play.machine.arm();
  TickEngine engine(rig, play.machine, source, play.limits, play.realtime, LatePolicy::abort, play.clock);
  const auto page = std::make_unique<GuardPage>();
  std::pair<long, long> seen;
  {
    const Trap trap;
    const LoopLinks links{play.clock, *play.queue, play.stop, play.board, page.get()};
    Loop(engine, play.machine, 1'000'000, links, play.report).run();
    seen = {Trap::allocations(), Trap::locks()};
  }
  play.drain();
  return seen;
}

std::pair<long, long> trapped_run(Play& play, hal::Rig& rig) {
  TableSource source(play.table_V, play.repetitions);
  return trapped_run(play, rig, source);
}

class TickPath : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Trap::works()) GTEST_SKIP() << "a sanitizer owns malloc in this build";
  }
};

TEST_F(TickPath, TrapCatchesAnAllocationAReleaseAndALock) {
  std::mutex mutex;
  const Trap trap;
  auto number = std::make_unique<int>(1);
  EXPECT_EQ(Trap::allocations(), 1);
  number.reset();
  EXPECT_EQ(Trap::allocations(), 2);
  mutex.lock();
  mutex.unlock();
  EXPECT_EQ(Trap::locks(), 1);
}

TEST_F(TickPath, NeitherAllocatesNorLocksInAnyStateOfAGoodRun) {
  FakeRig fake;
  Play play;
  EXPECT_EQ(trapped_run(play, fake), std::make_pair(0L, 0L));
  EXPECT_EQ(play.report.outcome, Outcome::completed);

  const std::unique_ptr<hal::Rig> sim = hal::open_rig(hal::SimOptions(), 0.0);
  Play simulated;
  EXPECT_EQ(trapped_run(simulated, *sim), std::make_pair(0L, 0L));
  EXPECT_EQ(simulated.report.outcome, Outcome::completed) << describe(simulated.report);
}

TEST_F(TickPath, NeitherAllocatesNorLocksWithSourcesThatLookAtTheRod) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(hal::SimOptions(), 0.0);
  Play placing;
  place::PlaceSource to_place(place::PlaceController(placing.limits, 0.001, 2.96), 4000);
  EXPECT_EQ(trapped_run(placing, *sim, to_place), std::make_pair(0L, 0L));
  EXPECT_EQ(placing.report.outcome, Outcome::completed) << describe(placing.report);

  Play held;
  const std::vector<double> predicted_in(held.table_V.size(), 0.0);
  place::StartingSource started(
      place::PlaceController(held.limits, 0.001, 2.95), held.limits, 0.001,
      std::make_unique<place::HoldSource>(held.table_V, predicted_in, 1U, config::HoldLaw{5.0, 1.0},
                                          place::LoopMonitor(place::loop_bounds(held.limits), 0.001)));
  EXPECT_EQ(trapped_run(held, *sim, started), std::make_pair(0L, 0L));
  EXPECT_EQ(held.report.outcome, Outcome::completed) << describe(held.report);
}

TEST_F(TickPath, NeitherAllocatesNorLocksWithAController) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(hal::SimOptions(), 0.0);
  Play tracking;
  track::TrackSource source(tracked(2.95, 2.97, 1.0), tracking.limits);  // as many rows as the queue holds
  EXPECT_EQ(trapped_run(tracking, *sim, source), std::make_pair(0L, 0L));
  EXPECT_EQ(tracking.report.outcome, Outcome::completed) << describe(tracking.report);
}

TEST_F(TickPath, NeitherAllocatesNorLocksOnAnyFault) {
  using hal::FaultKind;
  for (const FaultKind kind : {FaultKind::read_timed_out, FaultKind::read_io_error, FaultKind::command_timed_out,
                               FaultKind::command_io_error, FaultKind::removed, FaultKind::not_finite, FaultKind::rail,
                               FaultKind::spike, FaultKind::slow_read, FaultKind::emergency_stop}) {
    FakeRig fake;
    Play play;
    hal::FaultRig rig(fake, {{kind, 300, 10, 0.02}},
                      [&](std::int64_t duration_ns) { play.clock.advance(duration_ns); });
    EXPECT_EQ(trapped_run(play, rig), std::make_pair(0L, 0L)) << static_cast<int>(kind);
  }
}

/// Starts `true` again and again, as ehad starts its worker, until told to end.
void start_workers(const std::atomic<bool>& ended, std::atomic<int>& started) {
  while (!ended) {
    pid_t child = 0;
    char name[] = "true";
    char* arguments[] = {name, nullptr};
    if (posix_spawn(&child, "/bin/true", nullptr, nullptr, arguments, environ) != 0) return;
    waitpid(child, nullptr, 0);
    ++started;
  }
}

TEST_F(TickPath, TakesNoPageFaultOverSixtyThousandTicksWhileWorkersAreStarted) {
  RealtimeFacts facts;
  const RealtimeProcess process(facts);
  if (!facts.memory_locked) GTEST_SKIP() << "memory cannot be locked: " << facts.refused.front();
  FakeRig fake;
  Play play;
  play.table_V = cosine(60'000);
  play.machine.reset();
  play.machine.arm();
  std::atomic<bool> ended{false};
  std::atomic<int> started{0};
  std::thread consumer([&] {
    std::vector<TickRecord> batch(1024);
    while (!ended) {
      if (play.queue->pop(batch.data(), batch.size()) == 0) std::this_thread::yield();
    }
  });
  std::thread spawner([&] { start_workers(ended, started); });
  while (started == 0) std::this_thread::yield();
  TableSource source(play.table_V, 1);
  TickEngine engine(fake, play.machine, source, play.limits, play.realtime, LatePolicy::abort, play.clock);
  rusage before{};
  rusage after{};
  std::thread loop([&] {
    enter_realtime(play.realtime, facts);
    getrusage(RUSAGE_THREAD, &before);
    Loop(engine, play.machine, 1'000'000, {play.clock, *play.queue, play.stop, play.board}, play.report).run();
    getrusage(RUSAGE_THREAD, &after);
  });
  loop.join();
  ended = true;
  consumer.join();
  spawner.join();
  EXPECT_EQ(play.report.counters.experiment_rows, 60'000u);
  EXPECT_EQ(after.ru_minflt - before.ru_minflt, 0);
  EXPECT_EQ(after.ru_majflt - before.ru_majflt, 0);
}

}  // namespace
}  // namespace eha::acquisition
