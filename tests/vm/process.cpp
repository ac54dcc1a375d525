// SPDX-License-Identifier: GPL-3.0-or-later
#include "process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace eha::test {

Process::Process(const std::vector<std::string>& argv) : output_(memfd_create("output", MFD_CLOEXEC)) {
  if (output_ < 0) throw std::runtime_error(std::string("memfd_create: ") + std::strerror(errno));
  std::vector<char*> arguments;
  arguments.reserve(argv.size() + 1);
  for (const std::string& argument : argv) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output_, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output_, STDERR_FILENO);
  const int status = posix_spawnp(&id_, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (status != 0) {
    close(output_);
    throw std::runtime_error(argv.front() + ": " + std::strerror(status));
  }
}

Process::~Process() {
  if (exit_code_ < 0) {
    signal(SIGKILL);
    wait();
  }
  close(output_);
}

int Process::wait() {
  if (exit_code_ < 0) {
    int status = 0;
    while (waitpid(id_, &status, 0) < 0) {
      if (errno != EINTR) throw std::runtime_error(std::string("waitpid: ") + std::strerror(errno));
    }
    exit_code_ = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  }
  return exit_code_;
}

void Process::signal(int number) const {
  if (exit_code_ < 0) ::kill(id_, number);
}

std::string Process::output() const {
  std::string text;
  std::array<char, 4096> part{};
  for (off_t at = 0;; at = static_cast<off_t>(text.size())) {
    const ssize_t count = pread(output_, part.data(), part.size(), at);
    if (count <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(count));
  }
}

bool wait_until(const std::function<bool()>& holds, std::chrono::milliseconds patience) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace eha::test
