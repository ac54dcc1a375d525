// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/program.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

void check(int error_number, const char* what) {
  if (error_number != 0)
    throw std::runtime_error(std::string(what) + ": " + std::generic_category().message(error_number));
}

/// Where the child's standard streams go.
class FileActions {
 public:
  FileActions() { check(posix_spawn_file_actions_init(&actions_), "file actions"); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }

  void open(int descriptor, const fs::path& path, int flags) {
    check(posix_spawn_file_actions_addopen(&actions_, descriptor, path.c_str(), flags, 0600), "open");
  }
  void change_folder(const fs::path& folder) {
    check(posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str()), "chdir");
  }
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

/// A started `eha` with its streams in files.
class Program {
 public:
  Program(const std::vector<std::string>& arguments, const fs::path& at, const fs::path& output) : output_(output) {
    FileActions actions;
    actions.open(STDIN_FILENO, "/dev/null", O_RDONLY);
    actions.open(STDOUT_FILENO, output.empty() ? streams_.path() / "out" : output, O_WRONLY | O_CREAT);
    actions.open(STDERR_FILENO, streams_.path() / "err", O_WRONLY | O_CREAT);
    actions.change_folder(at);
    std::vector<std::string> words{EHA_PROGRAM};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    check(posix_spawn(&child_, EHA_PROGRAM, actions.get(), nullptr, argv.data(), environ), "posix_spawn");
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  ~Program() {
    if (running_) kill(child_, SIGKILL);
    if (running_) waitpid(child_, nullptr, 0);
  }

  void send(int signal) const { kill(child_, signal); }

  /// Whether it has ended. @param options  of waitpid: 0 waits for that, WNOHANG only looks
  bool wait(int options) {
    const pid_t got = waitpid(child_, &status_, options);
    if (got < 0) throw std::runtime_error("waitpid failed");
    running_ = got == 0;
    return !running_;
  }

  [[nodiscard]] Ended ended() const {
    return {WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_),
            output_.empty() ? content_of(streams_.path() / "out") : "", content_of(streams_.path() / "err")};
  }

 private:
  TemporaryFolder streams_;
  fs::path output_;
  pid_t child_ = -1;
  int status_ = 0;
  bool running_ = true;
};

}  // namespace

Ended run_eha(const std::vector<std::string>& arguments, const fs::path& at, const fs::path& output) {
  Program program(arguments, at, output);
  program.wait(0);
  return program.ended();
}

Ended interrupt_eha(const std::vector<std::string>& arguments, const fs::path& at, const std::function<bool()>& ready,
                    int signal) {
  Program program(arguments, at, {});
  while (!ready()) {
    if (program.wait(WNOHANG)) throw std::runtime_error("ended before it was ready: " + program.ended().err);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // leaves the processor to what it waits for
  }
  program.send(signal);
  program.wait(0);
  return program.ended();
}

std::string output_of_shell(const std::string& command) {
  std::string output;
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  for (int byte = fgetc(pipe); byte != EOF; byte = fgetc(pipe)) output += static_cast<char>(byte);
  pclose(pipe);
  return output;
}

std::size_t lines_beginning_with(const std::string& text, std::string_view beginning) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size();) {
    if (text.compare(at, beginning.size(), beginning) == 0) ++count;
    const std::size_t end = text.find('\n', at);
    if (end == std::string::npos) break;
    at = end + 1;
  }
  return count;
}

fs::path source_file(std::string_view name) { return fs::path(EHA_SOURCE_DIR) / name; }

}  // namespace eha::test
