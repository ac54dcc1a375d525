// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha-safe/guard_process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "fast_clock.hpp"
#include "snapshot_file.hpp"

namespace eha {
namespace {

bool exists(pid_t pid) { return std::filesystem::exists("/proc/" + std::to_string(pid)); }

TEST(GuardProcess, GoesQuietlyWhenItIsTold) {
  const testing::SnapshotFile snapshot;
  GuardProcess guard(EHA_SAFE, snapshot.path());
  const pid_t pid = guard.pid();
  EXPECT_TRUE(exists(pid));
  EXPECT_NO_THROW(guard.done());
  EXPECT_FALSE(exists(pid));
  EXPECT_NO_THROW(guard.done());
}

TEST(GuardProcess, IgnoresTheTerminalAndSignalsToTheWholeGroup) {
  const testing::SnapshotFile snapshot;
  GuardProcess guard(EHA_SAFE, snapshot.path());
  EXPECT_EQ(getsid(guard.pid()), guard.pid());
  EXPECT_EQ(kill(guard.pid(), SIGTERM), 0);
  EXPECT_EQ(kill(guard.pid(), SIGINT), 0);
  EXPECT_EQ(kill(guard.pid(), SIGABRT), 0);  // a service manager's watchdog
  EXPECT_NO_THROW(guard.done());
}

TEST(GuardProcess, IsStartedWithOpenSignalsEvenByAThreadThatBlocksThem) {
  const testing::SnapshotFile snapshot;
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, &all, &before), 0);
  GuardProcess guard(EHA_SAFE, snapshot.path());
  ASSERT_EQ(pthread_sigmask(SIG_SETMASK, &before, nullptr), 0);
  std::ifstream status("/proc/" + std::to_string(guard.pid()) + "/status");
  std::string line;
  while (std::getline(status, line) && line.rfind("SigBlk:", 0) != 0) {
  }
  EXPECT_EQ(line, "SigBlk:\t0000000000000000");
  guard.done();
}

TEST(GuardProcess, HoldsNoDescriptorOfItsParentThatIsCloseOnExec) {
  const testing::SnapshotFile snapshot;
  const int card = open("/dev/zero", O_RDONLY | O_CLOEXEC);
  ASSERT_GE(card, 0);
  GuardProcess guard(EHA_SAFE, snapshot.path());
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(guard.pid()) + "/fd")) {
    std::error_code closed_meanwhile;
    EXPECT_NE(std::filesystem::read_symlink(entry.path(), closed_meanwhile), "/dev/zero") << entry.path();
  }
  close(card);
  guard.done();
}

TEST(GuardProcess, ActsWhenItIsDroppedWithoutAWord) {
  const testing::FastClock clock;
  const testing::SnapshotFile snapshot;
  ::testing::internal::CaptureStderr();
  pid_t pid = -1;
  {
    const GuardProcess guard(EHA_SAFE, snapshot.path());
    pid = guard.pid();
  }
  EXPECT_FALSE(exists(pid));
  EXPECT_NE(::testing::internal::GetCapturedStderr().find("ended without making it safe"), std::string::npos);
}

/// Messages of the guard of a process that ends itself by a signal.
class GuardOfAProcess : public ::testing::TestWithParam<int> {};

TEST_P(GuardOfAProcess, ActsWhenThatIsKilledOrStopped) {
  const testing::FastClock clock;
  const testing::SnapshotFile snapshot;
  int report[2];
  ASSERT_EQ(pipe(report), 0);
  const pid_t parent = fork();
  ASSERT_GE(parent, 0);
  if (parent == 0) {
    close(report[0]);
    dup2(report[1], STDERR_FILENO);  // the guard inherits it
    const GuardProcess guard(EHA_SAFE, snapshot.path());
    kill(getpid(), GetParam());
  }
  close(report[1]);
  std::string heard;
  char byte = 0;
  while (read(report[0], &byte, 1) == 1) heard += byte;  // ends when the guard has ended
  close(report[0]);
  int status = 0;
  ASSERT_EQ(waitpid(parent, &status, 0), parent);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) << status;
  const char* const why = GetParam() == SIGKILL ? "ended without making it safe" : "was stopped and has been killed";
  EXPECT_NE(heard.find(why), std::string::npos) << heard;
}

INSTANTIATE_TEST_SUITE_P(Signals, GuardOfAProcess, ::testing::Values(SIGKILL, SIGSTOP));

TEST(GuardProcess, SaysSoWhenTheGuardDiedBeforeTheEnd) {
  const testing::SnapshotFile snapshot;
  GuardProcess guard(EHA_SAFE, snapshot.path());
  EXPECT_TRUE(guard.watches());
  ASSERT_EQ(kill(guard.pid(), SIGKILL), 0);
  while (guard.watches()) std::this_thread::yield();
  EXPECT_THROW(guard.done(), DeviceError);
}

TEST(GuardProcess, RefusesToGoOnWithoutAGuard) {
  const testing::SnapshotFile snapshot;
  EXPECT_THROW(GuardProcess("/no/such/program", snapshot.path()), DeviceError);
  EXPECT_THROW(GuardProcess("/bin/true", snapshot.path()), DeviceError);
  EXPECT_THROW(GuardProcess("/bin/echo", snapshot.path()), DeviceError) << "answers, but not what a guard answers";
  EXPECT_THROW(GuardProcess(EHA_SAFE, "/no/such/snapshot"), DeviceError);
}

TEST(GuardProcess, IsFoundBesideTheRunningProgram) {
  EXPECT_EQ(guard_program(), std::filesystem::read_symlink("/proc/self/exe").parent_path() / "eha-safe");
}

}  // namespace
}  // namespace eha
