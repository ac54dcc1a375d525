// SPDX-License-Identifier: GPL-3.0-or-later
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <new>
#include <random>
#include <thread>

#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/unit/passing_rig.hpp"
#include "tests/unit/record/record_fixture.hpp"

namespace eha::record {
namespace {

/// A simulated rig that reports the progress of the run to the parent process.
class CountingRig final : public test::PassingRig {
 public:
  CountingRig(hal::Rig& rig, std::atomic<std::int64_t>& ticks) : PassingRig(rig), ticks_(ticks) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    ticks_.store(elapsed_ns / 1'000'000, std::memory_order_relaxed);
    return PassingRig::read(elapsed_ns, reading);
  }

 private:
  std::atomic<std::int64_t>& ticks_;
};

class KilledRun : public RecordTest {};

TEST_F(KilledRun, LosesNoMoreThanTheLastFifthOfASecondFiftyTimes) {
  set_duration(20.0);
  // This is about the record; on a shared machine ticks may well be late.
  rig_config_.realtime.abort_consecutive_late = 1'000'000;
  rig_config_.realtime.abort_total_late = 1'000'000;
  void* memory = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto* ticks = new (memory) std::atomic<std::int64_t>(0);
  std::mt19937_64 random(5);
  for (int round = 0; round < 50; ++round) {
    ticks->store(0);
    const std::string runs = "runs" + std::to_string(round);
    const pid_t child = ::fork();
    if (child == 0) {
      const std::unique_ptr<hal::Rig> sim = hal::open_rig(std::get<hal::SimOptions>(rig_config_.backend), 0.0);
      CountingRig rig(*sim, *ticks);
      acquisition::StateMachine machine;
      machine.reset();
      machine.arm();
      play::PlayRequest wanted = request(runs);
      wanted.time_base = acquisition::TimeBase::monotonic;
      static_cast<void>(play::play(rig, machine, wanted, stop_));
      ::_exit(0);
    }
    const auto kill_at = static_cast<std::int64_t>(300 + random() % 1500);
    while (ticks->load() < kill_at && ::waitpid(child, nullptr, WNOHANG) == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_GE(ticks->load(), kill_at) << "the run ended by itself in round " << round;
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::int64_t last_tick = ticks->load();
    const std::vector<std::filesystem::path> torn = find_torn_runs(folder_ / runs);
    ASSERT_EQ(torn.size(), 1u);
    const Recovery recovery = recover_run(torn.front());
    EXPECT_GE(static_cast<std::int64_t>(recovery.rows), last_tick - 200) << "seed 5, round " << round;
    EXPECT_LE(static_cast<std::int64_t>(recovery.rows), last_tick + 1);
    EXPECT_EQ(recovery.outcome, acquisition::Outcome::recovered);
  }
  ::munmap(memory, 4096);
}

}  // namespace
}  // namespace eha::record
