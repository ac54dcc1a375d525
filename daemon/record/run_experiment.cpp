// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_experiment.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/fatal_signals.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/record/file_io.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_files.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {
namespace {

using acquisition::Outcome;
using acquisition::RecordQueue;
using acquisition::TickRecord;
using Json = nlohmann::ordered_json;

constexpr double kBlock_s = 0.1;
constexpr auto kSynchronise = std::chrono::seconds(1);
constexpr auto kProgressInterval = std::chrono::milliseconds(100);
constexpr auto kPollMonotonic = std::chrono::milliseconds(10);
constexpr auto kPollVirtual = std::chrono::microseconds(200);

/// Moves records from the queue into the journal in a thread of its own until told that the loop has ended.
class JournalTask {
 public:
  /// @param turns  counts on with every turn of the thread
  JournalTask(RecordQueue& queue, JournalWriter& journal, TimeBase time_base, std::atomic<std::uint64_t>& turns)
      : queue_(queue), journal_(journal), time_base_(time_base), turns_(turns), thread_([this] { run(); }) {
    pthread_setname_np(thread_.native_handle(), "eha-writer");
  }
  JournalTask(const JournalTask&) = delete;
  JournalTask& operator=(const JournalTask&) = delete;
  ~JournalTask() { finish(); }

  /// The loop has pushed its last record. @returns what the writer could not do, or nothing
  std::string finish() {
    loop_ended_.store(true, std::memory_order_release);
    if (thread_.joinable()) thread_.join();
    return error_;
  }

 private:
  void run() {
    acquisition::block_all_but_fatal_signals();
    const acquisition::SignalStack signal_stack;
    std::vector<TickRecord> batch(RecordQueue::kCapacity / 8);
    auto synchronised = std::chrono::steady_clock::now();
    for (;;) {
      turns_.fetch_add(1, std::memory_order_relaxed);
      const bool was_last = loop_ended_.load(std::memory_order_acquire);
      const std::size_t count = queue_.pop(batch.data(), batch.size());
      try {
        if (count > 0 && error_.empty()) journal_.append({batch.data(), count});
        // A run in virtual time can be had again; it is made durable once, at its end.
        const auto now = std::chrono::steady_clock::now();
        if (time_base_ == TimeBase::monotonic && error_.empty() && now - synchronised >= kSynchronise) {
          journal_.synchronise();
          synchronised = now;
        }
      } catch (const std::exception& error) {
        // From here on records are taken off the queue and lost; the loop ramps out.
        error_ = error.what();
        queue_.report_writer_failure();
      }
      if (count > 0) continue;
      if (was_last) return;
      if (time_base_ == TimeBase::monotonic) {
        std::this_thread::sleep_for(kPollMonotonic);
      } else {
        std::this_thread::sleep_for(kPollVirtual);
      }
    }
  }

  RecordQueue& queue_;
  JournalWriter& journal_;
  TimeBase time_base_;
  std::atomic<std::uint64_t>& turns_;
  std::string error_;
  std::atomic<bool> loop_ended_{false};
  std::thread thread_;
};

/// Whether a count has stood still for longer than the writer may hang. Belongs to one thread.
class WriterAlarm {
 public:
  explicit WriterAlarm(const std::atomic<std::uint64_t>& turns) : turns_(turns) {}

  [[nodiscard]] bool rings() {
    const std::uint64_t turns = turns_.load(std::memory_order_relaxed);
    const auto now = std::chrono::steady_clock::now();
    if (turns != last_turns_) {
      last_turns_ = turns;
      moved_ = now;
    }
    return now - moved_ > kWriterPatience;
  }

 private:
  const std::atomic<std::uint64_t>& turns_;
  std::uint64_t last_turns_ = 0;
  std::chrono::steady_clock::time_point moved_ = std::chrono::steady_clock::now();
};

/// Removes a run folder again unless the run began.
class FolderGuard {
 public:
  explicit FolderGuard(std::filesystem::path folder) : folder_(std::move(folder)) {}
  FolderGuard(const FolderGuard&) = delete;
  FolderGuard& operator=(const FolderGuard&) = delete;
  ~FolderGuard() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove_all(folder_, ignored);
  }
  void keep() { kept_ = true; }

 private:
  std::filesystem::path folder_;
  bool kept_ = false;
};

/// Room for the journal, raw.h5 and the decimated data, and some to spare.
std::uint64_t bytes_needed(const RunRequest& request) {
  constexpr double kBytesPerTick = 64.0 + 72.0 + 8.0;
  constexpr double kSpare = 16e6;
  const config::RigLimits& limits = request.rig.limits;
  const double ramps_s =
      limits.slew_V_per_s > 0.0 ? 2.0 * (limits.command_max_V - limits.command_min_V) / limits.slew_V_per_s : 0.0;
  const double ticks = static_cast<double>(request.table_V.size()) * request.experiment.repetitions +
                       (ramps_s + 1.0) / request.rig.realtime.sample_period_s;
  return static_cast<std::uint64_t>(ticks * kBytesPerTick + kSpare);
}

std::unique_ptr<acquisition::Clock> make_clock(TimeBase time_base) {
  if (time_base == TimeBase::virtual_time) return std::make_unique<acquisition::VirtualClock>();
  return std::make_unique<acquisition::MonotonicClock>();
}

/// Everything that may still fail once the rig is safe: what fails is put down, and what can be written is.
void write_files(FinishedRun& finished, JournalWriter* journal, Json& manifest) {
  const auto attempt = [&](const auto& work) {
    try {
      work();
    } catch (const std::exception& error) {
      if (finished.write_error.empty()) finished.write_error = error.what();
    }
  };
  if (journal != nullptr && finished.write_error.empty()) {
    attempt([&] { journal->finish(describe_end(finished.report)); });
  }
  attempt([&] { write_files_from_journal(finished.folder); });
  Outcome& outcome = finished.report.outcome;
  if (!finished.write_error.empty() && (outcome == Outcome::completed || outcome == Outcome::interrupted)) {
    outcome = Outcome::write_failed;
  }
  manifest["files"] = nullptr;
  manifest["outcome"] = acquisition::to_text(outcome);
  manifest["utc_end"] = utc_now();
  manifest["report"] = describe_report(finished.report);
  if (!finished.write_error.empty()) manifest["report"]["write_error"] = finished.write_error;
  attempt([&] { write_manifest(finished.folder, manifest); });
  if (!finished.write_error.empty() && outcome == Outcome::completed) outcome = Outcome::write_failed;
}

}  // namespace

FinishedRun run_experiment(hal::Rig& rig, acquisition::StateMachine& machine, const RunRequest& request,
                           acquisition::StopRequest& stop, const Progress& progress) {
  FinishedRun finished;
  const std::string utc_start = utc_now();
  finished.folder =
      request.folder.empty() ? create_run_folder(request.runs_folder, request.experiment.name) : request.folder;
  FolderGuard guard(finished.folder);
  require_free_space(finished.folder, bytes_needed(request));
  const Json header = describe_run(rig.capabilities(), request, utc_start);
  const double block = std::round(kBlock_s / request.rig.realtime.sample_period_s);
  JournalWriter journal(finished.folder / kJournalFile, header, static_cast<std::size_t>(std::max(block, 1.0)));
  Json manifest = new_manifest(header, utc_start);
  write_manifest(finished.folder, manifest);

  const std::unique_ptr<acquisition::Clock> clock = make_clock(request.time_base);
  const auto queue = std::make_unique<RecordQueue>();
  const auto own_watch = std::make_unique<RunWatch>();
  RunWatch& watch = request.watch != nullptr ? *request.watch : *own_watch;
  std::exception_ptr progress_failure;
  const auto report_progress = [&] {
    if (!progress || progress_failure) return;
    try {
      progress(watch.board.read());
    } catch (...) {
      // Nobody watches any more. The rod is ramped to rest and what it did is kept before anyone hears of it.
      progress_failure = std::current_exception();
      stop.request_ramp_out();
    }
  };
  {
    const acquisition::SignalStack signal_stack;
    const acquisition::FatalSignals fatal_signals(rig, stop, std::llround(request.rig.realtime.sample_period_s * 1e9));
    watch.phase = RunWatch::Phase::playing;
    JournalTask writer(*queue, journal, request.time_base, watch.writer_turns);
    WriterAlarm alarm(watch.writer_turns);
    std::future<acquisition::RunReport> loop = std::async(std::launch::async, [&] {
      const acquisition::Excitation excitation{request.table_V,
                                               static_cast<std::uint32_t>(request.experiment.repetitions)};
      return acquisition::run(rig, machine, excitation, request.rig.limits, request.rig.realtime, request.non_realtime,
                              *clock, *queue, stop, watch.board);
    });
    while (loop.wait_for(kProgressInterval) != std::future_status::ready) {
      report_progress();
      if (request.time_base == TimeBase::monotonic && alarm.rings()) queue->report_writer_failure();
    }
    finished.report = loop.get();
    watch.phase = RunWatch::Phase::draining;
    guard.keep();
    finished.write_error = writer.finish();
  }
  watch.phase = RunWatch::Phase::closing;
  report_progress();
  write_files(finished, &journal, manifest);
  if (progress_failure) std::rethrow_exception(progress_failure);
  return finished;
}

}  // namespace eha::record
