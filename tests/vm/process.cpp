// SPDX-License-Identifier: GPL-3.0-or-later
#include "process.hpp"

#include <fcntl.h>
#include <grp.h>
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
namespace {

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

}  // namespace

Process::Process(const std::vector<std::string>& argv, const ProcessOptions& options)
    : output_(memfd_create("output", MFD_CLOEXEC)) {
  if (output_ < 0) fail("memfd_create");
  std::vector<char*> arguments;
  arguments.reserve(argv.size() + 1);
  for (const std::string& argument : argv) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  std::array<int, 2> typed{open("/dev/null", O_RDONLY | O_CLOEXEC), -1};
  if (options.is_typed_into && pipe2(typed.data(), O_CLOEXEC) != 0) fail("pipe");
  id_ = fork();
  if (id_ < 0) fail("fork");
  if (id_ == 0) {
    const bool is_user =
        options.user == 0 || (setgroups(0, nullptr) == 0 && setgid(options.user) == 0 && setuid(options.user) == 0);
    if (is_user && dup2(typed[0], STDIN_FILENO) == STDIN_FILENO && dup2(output_, STDOUT_FILENO) == STDOUT_FILENO &&
        dup2(output_, STDERR_FILENO) == STDERR_FILENO) {
      execvp(arguments.front(), arguments.data());
    }
    _exit(127);
  }
  close(typed[0]);
  input_ = typed[1];
}

Process::~Process() {
  if (exit_code_ < 0) {
    signal(SIGKILL);
    wait();
  }
  close(output_);
  if (input_ >= 0) close(input_);
}

void Process::type(const std::string& line) const {
  const std::string text = line + "\n";
  if (write(input_, text.data(), text.size()) != static_cast<ssize_t>(text.size())) fail("typing");
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
