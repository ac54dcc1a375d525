// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/child_process.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

#include "core/error.hpp"

namespace eha::os {
namespace {

struct Pipe {
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    reading = FileDescriptor(ends[0]);
    writing = FileDescriptor(ends[1]);
  }
  /// Reads to the end of the file: every writing end must be closed by then.
  std::string read_all() {
    writing.close();
    std::string text;
    std::array<char, 256> bytes{};
    for (ssize_t count = 0; (count = ::read(reading.get(), bytes.data(), bytes.size())) > 0;) {
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return text;
  }
  FileDescriptor reading;
  FileDescriptor writing;
};

/// Standard output of a shell command.
std::string output_of(const std::string& script, Session session = Session::shared) {
  Pipe pipe;
  ChildProcess child({.words = {"/bin/sh", "-c", script}, .standard_output = &pipe.writing, .session = session});
  std::string text = pipe.read_all();
  const ChildEnd end = child.wait();
  EXPECT_TRUE(end.status && WIFEXITED(*end.status) && WEXITSTATUS(*end.status) == 0) << script;
  return text;
}

TEST(ChildProcess, TellsItsExitStatusOnce) {
  ChildProcess child({.words = {"/bin/sh", "-c", "exit 7"}});
  const ChildEnd end = child.wait();
  ASSERT_TRUE(end.status);
  EXPECT_EQ(WEXITSTATUS(*end.status), 7);
  EXPECT_EQ(child.pid(), -1);
  EXPECT_FALSE(child.wait().status);
}

TEST(ChildProcess, IsPolledUntilASignalEndsIt) {
  ChildProcess child({.words = {"/bin/sleep", "1000"}});
  EXPECT_FALSE(child.poll());
  EXPECT_TRUE(child.runs());
  child.signal(SIGKILL);
  std::optional<ChildEnd> end;
  while (!(end = child.poll())) std::this_thread::yield();
  ASSERT_TRUE(end->status);
  EXPECT_EQ(WTERMSIG(*end->status), SIGKILL);
  EXPECT_FALSE(child.runs());
}

TEST(ChildProcess, IsWaitedForWithALimit) {
  ChildProcess stays({.words = {"/bin/sleep", "1000"}});
  EXPECT_FALSE(stays.wait_for(std::chrono::milliseconds(20)));
  EXPECT_TRUE(stays.runs());
  stays.signal(SIGKILL);
  ChildProcess ends({.words = {"/bin/sh", "-c", "exit 7"}});
  const std::optional<ChildEnd> end = ends.wait_for(std::chrono::minutes(1));
  ASSERT_TRUE(end && end->status);
  EXPECT_EQ(WEXITSTATUS(*end->status), 7);
}

TEST(ChildProcess, DoesNotRunWhileItIsStopped) {
  ChildProcess child({.words = {"/bin/sleep", "1000"}});
  EXPECT_TRUE(child.runs());
  child.signal(SIGSTOP);
  const auto becomes = [&](bool running) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (child.runs() != running && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return child.runs() == running;
  };
  EXPECT_TRUE(becomes(false));
  EXPECT_FALSE(child.poll()) << "it has not ended";
  child.signal(SIGCONT);
  EXPECT_TRUE(becomes(true));
  child.signal(SIGKILL);
}

TEST(ChildProcess, HoldsItsStandardStreamsAlone) {
  const FileDescriptor leaked(::open("/dev/zero", O_RDONLY));  // without close-on-exec, as a library may open it
  ASSERT_TRUE(leaked);
  EXPECT_EQ(output_of("readlink /proc/$$/fd/0; ls -l /proc/$$/fd | grep -c /dev/zero; true"), "/dev/null\n0\n");
}

TEST(ChildProcess, BlocksAndIgnoresNoSignalWhateverItsStarterDoes) {
  sigset_t all;
  sigset_t before;
  sigfillset(&all);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, &all, &before), 0);
  const auto handler = ::signal(SIGPIPE, SIG_IGN);
  const std::string blocked = output_of("exec sed -n 's/SigBlk:.//p' /proc/self/status");
  const std::string ignored = output_of("exec sed -n 's/SigIgn:.//p' /proc/self/status");
  ::signal(SIGPIPE, handler);
  ASSERT_EQ(pthread_sigmask(SIG_SETMASK, &before, nullptr), 0);
  EXPECT_EQ(std::stoull(blocked, nullptr, 16), 0u);
  // The C library leaves its own signals 32 and 33 out of every set.
  EXPECT_EQ(std::stoull(ignored, nullptr, 16) & 0x7fffffffU, 0u);
}

TEST(ChildProcess, HasASessionOfItsOwnWhenItIsAskedFor) {
  const std::string print_session = "set -- $(cut -d' ' -f 6 /proc/$$/stat); test $1 = $$ && echo own || echo shared";
  EXPECT_EQ(output_of(print_session, Session::own), "own\n");
  EXPECT_EQ(output_of(print_session, Session::shared), "shared\n");
}

TEST(ChildProcess, SaysWhichProgramCannotBeStarted) {
  try {
    const ChildProcess child({.words = {"/no/such/program"}});
    FAIL() << "started a program that does not exist";
  } catch (const IoError& error) {
    EXPECT_STREQ(error.what(), "/no/such/program: cannot be started: No such file or directory");
  }
}

}  // namespace
}  // namespace eha::os
