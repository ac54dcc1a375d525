// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/run_records.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/child_process.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;
using std::chrono::steady_clock;

constexpr int kLongestWait_ms = 20;  // then the progress is shown, and a stop looked for
constexpr const char* kFitFile = "fit.json";
constexpr const char* kMessagesFile = "messages.txt";
constexpr std::size_t kLongestMessage = 8000;
constexpr std::string_view kPrefix = "eha: error: ";
constexpr std::size_t kProbe = 64 * 1024;  // bytes; more than messages and a document need

std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

/// Whether a process was terminated by a user, a batch system, or a machine short of memory, not because of its record.
bool was_told_to_end(int exit_code) {
  constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGKILL};
  return std::any_of(kSignals.begin(), kSignals.end(), [&](int number) { return exit_code == 128 + number; });
}

/// Returns the failure of the batch's own disk if a process ended with an input/output error; empty if the record could
/// not be read.
std::string disk_fault(const Result& result, const fs::path& folder) {
  if (result.exit_code != static_cast<int>(ExitCode::io)) return {};
  // Errors of a write only: a full disk, a quota, a limit on files, a disk that became read-only.
  for (const int number : {ENOSPC, EDQUOT, EFBIG, EROFS}) {
    if (result.message.find(error_text(number)) != std::string::npos) return result.message;
  }
  // A full disk takes no message either.
  try {
    const fs::path probe = folder / "probe";
    os::write_file_atomically(probe, std::string(kProbe, '.'));
    std::error_code ignored;
    fs::remove(probe, ignored);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

/// One record in progress.
class Fit {
 public:
  Fit(const Record& record, fs::path folder, const fs::path& program, const std::vector<std::string>& options)
      : record_(record),
        folder_(std::move(folder)),
        out_(os::open_file(folder_ / kFitFile, O_WRONLY | O_CREAT | O_TRUNC)),
        messages_(os::open_file(folder_ / kMessagesFile, O_WRONLY | O_CREAT | O_TRUNC)) {
    // Not an option, regardless of its first character.
    const std::string source = record.source.starts_with('-') ? "./" + record.source : record.source;
    std::vector<std::string> words{program.string(), "fit",          source, "-o", (folder_ / "models").string(),
                                   "--json",         "--no-progress"};
    own_output_ = " -o " + shell_quoted((folder_ / "models").string());
    words.insert(words.end(), options.begin(), options.end());
    process_ = std::make_unique<os::ChildProcess>(os::SpawnRequest{.words = std::move(words),
                                                                   .standard_output = &out_,
                                                                   .standard_error = &messages_,
                                                                   .session = os::Session::own});
    // Where the system gives none, the end is seen after kLongestWait_ms. No header of Debian 12's C library declares
    // pidfd_open() for C++.
    end_ = os::FileDescriptor(static_cast<int>(syscall(SYS_pidfd_open, process_->pid(), 0U)));
  }

  [[nodiscard]] const Record& record() const noexcept { return record_; }
  [[nodiscard]] const fs::path& folder() const noexcept { return folder_; }
  /// ": bench.csv, 12 s"
  [[nodiscard]] std::string progress() const {
    return fmt::format(": {}, {:.0f} s", fs::path(record_.source).filename().string(),
                       std::chrono::duration<double>(steady_clock::now() - begun_).count());
  }
  void kill() const noexcept { process_->signal(SIGKILL); }

  /// Is readable when the process has ended.
  [[nodiscard]] pollfd end() const noexcept { return {end_.get(), POLLIN, 0}; }

  [[nodiscard]] bool has_ended() noexcept {
    if (status_) return true;
    status_ = process_->poll();
    seconds_ = std::chrono::duration<double>(steady_clock::now() - begun_).count();
    return status_.has_value();
  }

  /// The result of a process that has ended.
  [[nodiscard]] Result result() const {
    Result result;
    result.seconds = seconds_;
    result.host = host_name();
    result.message = os::read_regular_file(folder_ / kMessagesFile);
    leave_out_own_words(result.message);
    if (result.message.size() > kLongestMessage) result.message.erase(0, result.message.size() - kLongestMessage);
    const int status = status_->status.value_or(0);
    if (status_->status && WIFSIGNALED(status)) {
      result.exit_code = 128 + WTERMSIG(status);
      result.message += fmt::format("ended by signal {} ({})\n", WTERMSIG(status), strsignal(WTERMSIG(status)));
    } else {
      result.exit_code = status_->status ? WEXITSTATUS(status) : static_cast<int>(ExitCode::bug);
    }
    result.fit = parse_json_text<nlohmann::ordered_json>(os::read_regular_file(folder_ / kFitFile));
    if (!result.fit.is_object() || !result.fit.contains("models")) result.fit = nullptr;
    std::error_code ignored;
    fs::remove(folder_ / kFitFile, ignored);
    fs::remove(folder_ / kMessagesFile, ignored);
    // The models' documents, also stored in the folder `models`, name this folder by its earlier path.
    if (is_judged(result)) result.fit.erase("files");
    return result;
  }

 private:
  /// A command in a message repeats what was typed; a user types neither the work folder nor what the batch reads.
  void leave_out_own_words(std::string& message) const {
    // A message may name the next free folder, "models-2".
    const bool is_quoted = own_output_.ends_with('\'');
    const std::string output = own_output_.substr(0, own_output_.size() - (is_quoted ? 1 : 0));
    for (std::size_t at = message.find(output); at != std::string::npos; at = message.find(output, at)) {
      const std::size_t end = message.find_first_of(is_quoted ? "'" : " `\n", at + output.size());
      message.erase(at, end == std::string::npos ? end : end - at + (is_quoted ? 1 : 0));
    }
    constexpr std::string_view kFlags = " --json --no-progress";
    for (std::size_t at = message.find(kFlags); at != std::string::npos; at = message.find(kFlags, at)) {
      message.erase(at, kFlags.size());
    }
  }

  Record record_;
  fs::path folder_;
  os::FileDescriptor out_;
  os::FileDescriptor messages_;
  std::string own_output_;  ///< of the command line, quoted for a shell
  steady_clock::time_point begun_ = steady_clock::now();
  double seconds_ = 0.0;
  std::optional<os::ChildEnd> status_;
  os::FileDescriptor end_;
  std::unique_ptr<os::ChildProcess> process_;
};

/// Waits until one of the processes has ended, at most kLongestWait_ms.
void wait_for_end(const std::vector<std::unique_ptr<Fit>>& running) {
  if (running.empty()) return;
  std::vector<pollfd> ends;
  for (const auto& fit : running) ends.push_back(fit->end());
  static_cast<void>(poll(ends.data(), ends.size(), kLongestWait_ms));
}

}  // namespace

bool run_records(BatchFolder& folder, const RunOptions& options) {
  folder.claim(options.shard);
  const std::vector<Record> open = folder.open_records(options.shard);
  // Without a file among the rules, a configuration error is in one run only.
  const std::vector<std::string>& contents = folder.batch().rules.contents;
  const bool rules_name_files =
      std::any_of(contents.begin(), contents.end(), [](const auto& sum) { return !sum.empty(); });
  std::vector<std::unique_ptr<Fit>> running;
  const auto end_all = [&] {
    for (const auto& fit : running) fit->kill();
    running.clear();
  };
  std::size_t begun = 0;
  std::size_t done = 0;
  bool all_have_results = true;
  const auto take_result_of = [&](const Fit& fit) {
    const Result result = fit.result();
    if (rules_name_files && result.exit_code == static_cast<int>(ExitCode::configuration)) {
      end_all();
      throw ConfigError("the rules of the batch are wrong: " + result.message);
    }
    if (std::string fault = disk_fault(result, fit.folder()); !fault.empty()) {
      end_all();
      while (fault.ends_with('\n')) fault.pop_back();
      if (fault.starts_with(kPrefix)) fault.erase(0, kPrefix.size());
      throw IoError(
          fmt::format("the batch stops at {}, because its disk fails: {}; make room, then the same command goes on "
                      "with the open records",
                      fit.record().source, fault));
    }
    if (was_told_to_end(result.exit_code)) {
      all_have_results = false;
    } else {
      folder.publish(fit.record(), result);
    }
    ++done;
  };
  const auto has_ended = [](const std::unique_ptr<Fit>& fit) { return fit->has_ended(); };
  while (done < open.size()) {
    if (options.stopped()) {
      end_all();
      return false;
    }
    const auto first_ended = std::stable_partition(running.begin(), running.end(), std::not_fn(has_ended));
    const std::vector<std::unique_ptr<Fit>> ended(std::make_move_iterator(first_ended),
                                                  std::make_move_iterator(running.end()));
    running.erase(first_ended, running.end());
    // Before the results are written, so that no processor waits for the disk.
    while (running.size() < options.jobs && begun < open.size()) {
      const Record& next = open[begun++];
      running.push_back(
          std::make_unique<Fit>(next, folder.work_folder(next), options.program, folder.batch().rules.options));
    }
    for (const auto& fit : ended) take_result_of(*fit);
    const double share = static_cast<double>(done) / static_cast<double>(open.size());
    // The record that has run longest, whose seconds show that it goes on.
    const std::string at_work = running.empty() ? std::string() : running.front()->progress();
    options.progress(share, fmt::format("record {} of {}{}", std::min(done + 1, open.size()), open.size(), at_work));
    wait_for_end(running);
  }
  return all_have_results;
}

}  // namespace eha::batch
