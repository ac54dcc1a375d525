// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/reader_confinement.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/os/files.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::importer {
namespace {

/// What a confined process could still do, in one letter each.
std::string left_to(const std::filesystem::path& own, const std::filesystem::path& other) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const os::FileDescriptor file = os::open_file(own, O_RDONLY);
    if (!confine_to(file.get())) _exit(1);
    const auto note = [&](char letter, bool is_possible) {
      if (is_possible && write(ends[1], &letter, 1) != 1) _exit(2);
    };
    const std::string link = "/proc/self/fd/" + std::to_string(file.get());
    note('r', open(link.c_str(), O_RDONLY) >= 0);
    note('o', open(other.c_str(), O_RDONLY) >= 0);
    note('w', open(own.c_str(), O_RDWR) >= 0);
    note('c', open((other.string() + "-new").c_str(), O_WRONLY | O_CREAT, 0600) >= 0);
    note('u', unlink(other.c_str()) == 0);
    note('s', socket(AF_UNIX, SOCK_STREAM, 0) >= 0);
    note('k', kill(getppid(), 0) == 0);
    note('g', fcntl(ends[1], F_SETOWN, getppid()) == 0 || fcntl(ends[1], F_SETSIG, SIGKILL) == 0);
    rlimit limit{};
    note('l', prlimit(getppid(), RLIMIT_CPU, nullptr, &limit) == 0);
    note('d', fcntl(ends[1], F_GETFD) < 0 || prlimit(0, RLIMIT_CPU, nullptr, &limit) != 0);
    note('t', ioctl(0, FIONREAD, &ends[0]) == 0);
    const pid_t grandchild = fork();
    if (grandchild == 0) _exit(0);
    note('f', grandchild > 0);
    char name[] = "/bin/true";
    char* words[] = {name, nullptr};
    execv(name, words);
    _exit(0);
  }
  close(ends[1]);
  std::string left;
  for (char letter = 0; read(ends[0], &letter, 1) == 1;) left += letter;
  close(ends[0]);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0) << "the process was to be confined and to end by itself";
  return left;
}

bool has_landlock() {
  // Its version, or an error.
  return syscall(444, nullptr, 0, 1U) > 0;
}

TEST(ReaderConfinement, LeavesTheOneFileAndNothingElse) {
  const test::TemporaryFolder folder;
  const auto own = folder.write("own", "1");
  const auto other = folder.write("other", "2");
  EXPECT_EQ(left_to(own, other), has_landlock() ? "r" : "ro");
  EXPECT_TRUE(std::filesystem::exists(other));
}

TEST(ReaderConfinement, LetsAReaderAbortItself) {
  const test::TemporaryFolder folder;
  const auto own = folder.write("own", "1");
  const pid_t child = fork();
  if (child == 0) {
    const rlimit none{};
    setrlimit(RLIMIT_CORE, &none);
    const os::FileDescriptor file = os::open_file(own, O_RDONLY);
    if (!confine_to(file.get())) _exit(1);
    std::abort();
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << status;
  EXPECT_EQ(WTERMSIG(status), SIGABRT);
}

}  // namespace
}  // namespace eha::importer
