// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/os/file_descriptor.hpp"
#include "tests/system/stand_in_card.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {

/// A rig on a card for the built programs: the card is the stand-in, seen from this process.
class DrivenRig {
 public:
  DrivenRig();
  DrivenRig(const DrivenRig&) = delete;
  DrivenRig& operator=(const DrivenRig&) = delete;
  ~DrivenRig();

  /// Why it cannot be driven here; empty when it can. It takes root, whom a rig file must belong to, and SCHED_FIFO.
  [[nodiscard]] static std::string obstacle();

  [[nodiscard]] CardMemory& card() { return *card_; }
  [[nodiscard]] const CardMemory& card() const { return *card_; }
  /// A fresh card: position, counters and faults.
  void reset();
  /// NAME=VALUE for the programs that are to find the card.
  [[nodiscard]] std::vector<std::string> environment() const;
  /// The sample rig file. @param cpu  of the loop; none: any
  [[nodiscard]] static std::string rig_text(std::optional<int> cpu);

  /// Waits until the hydraulics are on and the loop has made `ticks` ticks since reset(). @returns whether that
  /// happened
  bool is_driven(std::uint64_t ticks) const;

  /// Keeps the analogue output from everybody else for as long as the result lives, as a process does that is still
  /// dying. @throws std::runtime_error  somebody else has it
  [[nodiscard]] os::FileDescriptor take_output() const;

 private:
  std::filesystem::path file_;
  CardMemory* card_ = nullptr;
};

/// A program under test with its messages, and every process that it starts.
class Driver {
 public:
  Driver(std::vector<std::string> words, const std::vector<std::string>& environment, const std::filesystem::path& at);
  Driver(const Driver&) = delete;
  Driver& operator=(const Driver&) = delete;
  ~Driver();

  [[nodiscard]] pid_t pid() const { return pid_; }
  void send(int signal) const;
  /// Ends the program alone by a signal and waits for that.
  void end(int signal);
  /// Waits for the end of the program and of all that have its messages' stream, such as its guard.
  /// @returns exit code, 128 + the signal's number
  int wait();
  [[nodiscard]] const std::string& messages() const { return messages_; }

 private:
  pid_t pid_ = -1;
  int stream_ = -1;
  std::string messages_;
};

/// Processes that take processors with SCHED_FIFO 90 for a time.
class Hogs {
 public:
  Hogs(const std::vector<int>& cpus, std::chrono::milliseconds duration);
  Hogs(const Hogs&) = delete;
  Hogs& operator=(const Hogs&) = delete;
  /// Waits for their end.
  ~Hogs();
  /// When the last of them had its processor; CLOCK_MONOTONIC [ns]. Waits for their end.
  std::int64_t begun_ns();

 private:
  void wait();
  std::vector<pid_t> hogs_;
  std::atomic<std::int64_t>* begun_ns_ = nullptr;
};

/// The only run folder below `runs`.
[[nodiscard]] std::filesystem::path only_run(const std::filesystem::path& runs);

/// Ticks that ran, in a run's journal.
[[nodiscard]] std::uint64_t ticks_recorded(const std::filesystem::path& run);

/// A thread of a process, by its name. @throws std::runtime_error
[[nodiscard]] pid_t thread_named(pid_t process, const std::string& name);

/// The only child of a process, such as its guard. @throws std::runtime_error
[[nodiscard]] pid_t child_of(pid_t process);

/// Whether a thread of a process waits for a disk.
[[nodiscard]] bool waits_for_disk(pid_t process);

}  // namespace eha::test
