// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/fatal_signals.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <new>
#include <thread>

#include "daemon/acquisition/run.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"

namespace eha::acquisition {
namespace {

/// The child's rig as the parent sees it.
struct Wire {
  std::atomic<double> voltage_V{0.0};
  std::atomic<bool> enabled{false};
  std::atomic<int> commands_after_safe{0};
  std::atomic<bool> made_safe{false};
};

/// A rig whose wire is memory shared with the parent.
class SharedRig final : public hal::Rig {
 public:
  explicit SharedRig(Wire& wire) : wire_(wire) {}
  [[nodiscard]] const hal::RigCapabilities& capabilities() const noexcept override { return fake_.capabilities(); }
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    if (fail_at_tick >= 0 && elapsed_ns >= fail_at_tick * 1'000'000) ::raise(SIGSEGV);
    return fake_.read(elapsed_ns, reading);
  }
  hal::RigStatus command(double command_V, hal::AppliedCommand& applied) noexcept override {
    if (wire_.made_safe) ++wire_.commands_after_safe;
    wire_.voltage_V = command_V;
    return fake_.command(command_V, applied);
  }
  hal::RigStatus set_enable(bool on) noexcept override {
    wire_.enabled = on;
    return fake_.set_enable(on);
  }
  hal::RigStatus make_safe() noexcept override {
    wire_.made_safe = true;
    wire_.voltage_V = 0.0;
    wire_.enabled = false;
    return hal::RigStatus::ok;
  }

  std::int64_t fail_at_tick = -1;

 private:
  Wire& wire_;
  FakeRig fake_;
};

class FatalSignal : public ::testing::Test {
 protected:
  void SetUp() override {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "the sanitizer handles fatal signals itself in this build";
#endif
    void* memory = ::mmap(nullptr, sizeof(Wire), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    ASSERT_NE(memory, MAP_FAILED);
    wire_ = new (memory) Wire;
  }
  void TearDown() override {
    if (wire_ != nullptr) ::munmap(wire_, sizeof(Wire));
  }

  /// Runs a long experiment in a child that dies of a signal. @returns the signal
  template <typename WhileRunning>
  int die_in_child(std::int64_t fail_at_tick, WhileRunning&& while_running) {
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      SharedRig rig(*wire_);
      rig.fail_at_tick = fail_at_tick;
      Play play;
      play.table_V.assign(6000, 0.3);
      play.limits.frozen_sensor_s = 0.0;
      const FatalSignals guard(rig, play.stop, 1'000'000);
      std::thread loop([&] {
        play.machine.reset();
        play.machine.arm();
        MonotonicClock clock;
        TableSource source(play.table_V, 1);
        static_cast<void>(run(rig, play.machine, source, play.limits, play.realtime, NonRealtime::allow, clock,
                              *play.queue, play.stop, play.board));
      });
      while (!wire_->enabled && !wire_->made_safe) std::this_thread::yield();
      while_running();
      loop.join();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  }

  Wire* wire_ = nullptr;
};

TEST_F(FatalSignal, InAnotherThreadLeavesTheRigSafeAndKillsTheProcessAllTheSame) {
  for (const int signal_number : {SIGSEGV, SIGABRT, SIGFPE}) {
    new (wire_) Wire;
    EXPECT_EQ(die_in_child(-1, [&] { ::raise(signal_number); }), signal_number);
    EXPECT_TRUE(wire_->made_safe);
    EXPECT_FALSE(wire_->enabled);
    EXPECT_EQ(wire_->voltage_V, 0.0);
    EXPECT_EQ(wire_->commands_after_safe, 0) << "the loop wrote over the safe voltage";
  }
}

TEST_F(FatalSignal, InTheLoopItselfLeavesTheRigSafe) {
  EXPECT_EQ(die_in_child(150, [] {}), SIGSEGV);
  EXPECT_TRUE(wire_->made_safe);
  EXPECT_FALSE(wire_->enabled);
  EXPECT_EQ(wire_->commands_after_safe, 0);
}

TEST_F(FatalSignal, InAThirdThreadLeavesTheRigSafeAlthoughTheRunIsOverBeforeTheHandler) {
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    setrlimit(RLIMIT_CORE, &no_core);
    SharedRig rig(*wire_);
    StopRequest stop;
    wire_->enabled = true;
    {
      const FatalSignals guard(rig, stop, 100'000'000);  // the handler waits 0.2 s
      std::thread([] { ::raise(SIGSEGV); }).detach();
      while (!stop.outputs_taken()) std::this_thread::yield();
    }
    ::_exit(0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGSEGV);
  EXPECT_TRUE(wire_->made_safe);
  EXPECT_FALSE(wire_->enabled);
}

TEST_F(FatalSignal, HandlersAreGoneWithTheGuard) {
  SharedRig rig(*wire_);
  StopRequest stop;
  { const FatalSignals guard(rig, stop, 1'000'000); }
  struct sigaction action {};
  sigaction(SIGSEGV, nullptr, &action);
  EXPECT_EQ(action.sa_handler, SIG_DFL);
}

}  // namespace
}  // namespace eha::acquisition
