// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/play.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <future>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>

#include "core/os/files.hpp"
#include "daemon/acquisition/circuits_at_rest.hpp"
#include "daemon/acquisition/fatal_signals.hpp"
#include "daemon/acquisition/record_queue.hpp"
#include "daemon/delays/run_delays.hpp"
#include "daemon/play/journal_thread.hpp"
#include "daemon/play/volts_source.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/report_json.hpp"
#include "daemon/record/run_files.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"

namespace eha::play {
namespace {

using acquisition::Outcome;
using acquisition::TimeBase;

constexpr std::chrono::milliseconds kSafeAgain{1000};
constexpr std::chrono::milliseconds kSafeAgainPause{5};
constexpr double kBlock_s = 0.1;
constexpr auto kProgressInterval = std::chrono::milliseconds(100);
constexpr auto kRestRead = std::chrono::milliseconds(20);  // of a rig whose run has ended
constexpr int kLeftOutAfterFailure = 49;                   // readings: one a second

/// Removes a run folder again unless the run has begun.
class UnusedFolderRemover {
 public:
  explicit UnusedFolderRemover(std::filesystem::path folder) : folder_(std::move(folder)) {}
  UnusedFolderRemover(const UnusedFolderRemover&) = delete;
  UnusedFolderRemover& operator=(const UnusedFolderRemover&) = delete;
  ~UnusedFolderRemover() {
    std::error_code ignored;
    if (!has_begun_) std::filesystem::remove_all(folder_, ignored);
  }
  void run_has_begun() { has_begun_ = true; }

 private:
  std::filesystem::path folder_;
  bool has_begun_ = false;
};

/// Shows a run's progress until the display fails; then stops the run and keeps the failure.
class ProgressDisplay {
 public:
  ProgressDisplay(const Progress& progress, const RunWatch& watch, acquisition::StopRequest& stop)
      : progress_(progress), watch_(watch), stop_(stop) {}

  void show() {
    if (!progress_ || failure_) return;
    try {
      progress_(watch_.board.read());
    } catch (...) {
      // Rethrown only after the rod has been ramped to rest and the record is written.
      failure_ = std::current_exception();
      stop_.request_ramp_out();
    }
  }

  void rethrow_failure() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  const Progress& progress_;
  const RunWatch& watch_;
  acquisition::StopRequest& stop_;
  std::exception_ptr failure_;
};

/// Ticks of the experiment and its ramps; a placing before it makes more.
std::uint64_t expected_ticks(const PlayRequest& request) {
  const config::RigLimits& limits = request.rig.limits;
  const double ramps_s =
      limits.slew_V_per_s > 0.0 ? 2.0 * (limits.command_max_V - limits.command_min_V) / limits.slew_V_per_s : 0.0;
  const double ticks = static_cast<double>(request.table_V.size()) * request.experiment.repetitions +
                       (ramps_s + 1.0) / request.rig.realtime.sample_period_s;
  return static_cast<std::uint64_t>(ticks);
}

/// Disk space for the journal, raw.h5 and the decimated data, with a reserve.
std::uint64_t bytes_needed(const PlayRequest& request) {
  constexpr std::uint64_t kBytesPerTick = 64 + 72 + 8;
  constexpr std::uint64_t kSpare = 16'000'000;
  return expected_ticks(request) * kBytesPerTick + kSpare;
}

std::size_t rows_per_block(double sample_period_s) {
  return static_cast<std::size_t>(std::max(std::round(kBlock_s / sample_period_s), 1.0));
}

std::unique_ptr<acquisition::Clock> make_clock(TimeBase time_base) {
  if (time_base == TimeBase::virtual_time) return std::make_unique<acquisition::VirtualClock>();
  return std::make_unique<acquisition::MonotonicClock>();
}

/// Objects of a run.
struct RunParts {
  hal::Rig& rig;
  acquisition::StateMachine& machine;
  const PlayRequest& request;
  acquisition::StopRequest& stop;
  RunWatch& watch;
};

/// Goes on to write the safe state to a card that has refused it at the end of the loop. Then the guard need not act.
bool becomes_safe(hal::Rig& rig, GuardPage* page) {
  if (page != nullptr) page->beat();
  const auto deadline = std::chrono::steady_clock::now() + kSafeAgain;
  while (rig.make_safe() != hal::RigStatus::ok) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(kSafeAgainPause);
  }
  if (page != nullptr && GuardPage::is_driven(page->drive())) page->end_drive();
  return true;
}

/// Reads the lines of a machine whose run has ended: nobody else does, and an emergency stop that is pressed and reset
/// before the next run must be known. A card that is not confirmed safe is the guard's, and after a fault nothing
/// follows: of those no line is read.
class LinesAfterRun {
 public:
  LinesAfterRun(hal::Rig& rig, FinishedRun& finished)
      : rig_(rig),
        finished_(finished),
        is_watched_(rig.capabilities().moves_machine && finished.report.safe_confirmed &&
                    finished.report.fault.fault == acquisition::Fault::none) {}

  /// Does the work in a thread of its own and reads meanwhile.
  void during(const std::function<void()>& work) {
    std::future<void> working;
    try {
      if (is_watched_) working = std::async(std::launch::async, work);
    } catch (const std::system_error&) {  // no thread is to be had
    }
    if (working.valid()) {
      while (working.wait_for(kRestRead) != std::future_status::ready) read();
      working.get();
    } else {
      work();
    }
    if (is_watched_) read();  // also after work that is done at once
  }

  /// Reads until a contactor has dropped out, or must have.
  void await_drop_out() {
    if (!is_watched_ || !rig_.capabilities().has_enable_contact) return;
    const auto longest = acquisition::longest_drop_out(rig_.capabilities());
    while (read() && since_off() <= longest) std::this_thread::sleep_for(kRestRead);
    if (since_off() > longest) read();
  }

 private:
  [[nodiscard]] std::chrono::duration<double> since_off() const {
    return std::chrono::steady_clock::now() - finished_.ended;
  }
  /// @returns whether the contact is still closed, as far as is known
  bool read() {
    if (finished_.circuit != acquisition::CircuitAtRest::sound) return false;
    // A card that does not answer takes long for each reading.
    if (left_out_ > 0) return --left_out_ >= 0;
    hal::RigReading reading;
    const auto begun = std::chrono::steady_clock::now();
    if (rig_.read(0, reading) != hal::RigStatus::ok) {
      if (std::chrono::steady_clock::now() - begun > acquisition::kSlowFailure) left_out_ = kLeftOutAfterFailure;
      return true;
    }
    finished_.circuit = acquisition::circuit_at_rest(rig_, reading, since_off());
    return reading.enable_contact;
  }

  hal::Rig& rig_;
  FinishedRun& finished_;
  bool is_watched_;
  int left_out_ = 0;
};

/// Runs the tick loop and the journal's thread until both have ended.
/// @param is_journal_sound  set: every write to the journal succeeded
/// @throws as acquisition::run, before the first tick
FinishedRun record_run(const RunParts& run, record::JournalWriter& journal, ProgressDisplay& display,
                       bool& is_journal_sound) {
  const PlayRequest& request = run.request;
  const std::unique_ptr<acquisition::Clock> clock = make_clock(request.time_base);
  const auto queue = std::make_unique<acquisition::RecordQueue>();
  const acquisition::SignalStack signal_stack;
  const acquisition::FatalSignals fatal_signals(run.rig, run.stop,
                                                std::llround(request.rig.realtime.sample_period_s * 1e9));
  run.watch.phase = RunWatch::Phase::playing;
  const record::FolderWatch folder(request.folder);
  JournalThread writer(*queue, journal, folder, request.time_base, run.watch);
  const bool is_real_time = request.time_base == TimeBase::monotonic;
  const delays::Counters before = is_real_time ? delays::read_counters("/") : delays::Counters{};
  const auto play_source = [&](acquisition::CommandSource& source) {
    return acquisition::run(run.rig, run.machine, source, request.rig.limits, request.rig.realtime,
                            request.non_realtime, *clock, *queue, run.stop, run.watch.board, request.page,
                            request.earlier);
  };
  if (request.before_driven) request.before_driven(run.rig);
  std::future<acquisition::RunReport> loop = std::async(std::launch::async, [&] {
    if (request.early_end == nullptr) return play_source(*make_source(request));
    EarlyEndSource source(make_source(request), *request.early_end, request.time_base);
    acquisition::RunReport report = play_source(source);
    if (report.outcome == Outcome::completed && source.ended_early()) report.outcome = Outcome::precise_enough;
    return report;
  });
  while (loop.wait_for(kProgressInterval) != std::future_status::ready) {
    display.show();
    if (request.early_end != nullptr && (queue->writer_failed() || run.stop.count() > 0)) {
      request.early_end->give_up();  // no further row comes, and the loop must not wait for a verdict
    } else if (request.early_end != nullptr) {
      request.early_end->note(static_cast<int>(run.watch.journal_rows.load() / request.table_V.size()));
    }
    if (writer.hangs()) queue->report_writer_failure();
  }
  acquisition::RunReport report = loop.get();
  // Before the files, which may take long.
  if (!report.safe_confirmed && is_real_time) report.safe_confirmed = becomes_safe(run.rig, request.page);
  const acquisition::Snapshot last = run.watch.board.read();
  FinishedRun finished{.folder = request.folder,
                       .report = std::move(report),
                       .write_error = {},
                       .only_placed = request.experiment.placing() != nullptr,
                       .displacement_in = last.displacement_in,
                       .velocity_in_per_s = last.velocity_in_per_s,
                       .ended = std::chrono::steady_clock::now()};
  const acquisition::LoopCounters& counted = finished.report.counters;
  if (is_real_time && (counted.late > 0 || counted.skipped > 0)) {
    finished.delays = delays::delays_of_run(before, request.rig.realtime, finished.report);
  }
  run.watch.phase = RunWatch::Phase::draining;
  LinesAfterRun(run.rig, finished).during([&] { finished.write_error = writer.finish(); });
  is_journal_sound = writer.journal_is_sound();
  return finished;
}

/// Closes the journal and writes the files made from it. Stores a failure in `finished` and still writes the remaining
/// files.
/// @param folder   of the run, held open   @param journal  none: it cannot be closed
void write_files(FinishedRun& finished, const std::filesystem::path& folder, record::JournalWriter* journal,
                 record::Manifest& manifest) {
  const auto attempt = [&](const auto& work) {
    try {
      work();
    } catch (const std::exception& error) {
      if (finished.write_error.empty()) finished.write_error = error.what();
    }
  };
  if (journal != nullptr) attempt([&] { journal->finish(record::describe_end(finished.report)); });
  attempt([&] { record::write_files_from_journal(folder); });
  Outcome& outcome = finished.report.outcome;
  if (!finished.write_error.empty() && (acquisition::is_whole(outcome) || outcome == Outcome::interrupted)) {
    outcome = Outcome::write_failed;
  }
  manifest.files.clear();
  record::put_report(manifest, finished.report, finished.write_error);
  for (const delays::Delay& delay : finished.delays) {
    manifest.other["report"]["delays"].push_back(delays::to_json(delay));
  }
  attempt([&] { record::write_manifest(folder, manifest); });
  if (!finished.write_error.empty() && acquisition::is_whole(outcome)) outcome = Outcome::write_failed;
}

}  // namespace

FinishedRun play(hal::Rig& rig, acquisition::StateMachine& machine, const PlayRequest& request,
                 acquisition::StopRequest& stop, const Progress& progress) {
  UnusedFolderRemover remover(request.folder);
  // Held open: who owns the folder above may put another one in its place.
  const os::FileDescriptor held = os::open_folder(request.folder);
  const std::filesystem::path folder = os::path_through(held);
  os::require_free_space(folder, bytes_needed(request));
  const record::RunDescription description{.rig = request.rig,
                                           .experiment = request.experiment,
                                           .samples_per_repetition = request.table_V.size(),
                                           .time_base = request.time_base,
                                           .utc_start = record::utc_now()};
  const nlohmann::ordered_json header = record::describe_run(rig.capabilities(), description);
  record::JournalWriter journal(folder / record::kJournalFile, header,
                                rows_per_block(request.rig.realtime.sample_period_s), request.page,
                                expected_ticks(request));
  if (request.share_journal) request.share_journal(journal.file());
  record::Manifest manifest = record::new_manifest(header, description.utc_start);
  manifest.other["played_by"] = request.played_by == PlayedBy::eha ? "eha" : "ehad";
  record::write_manifest(folder, manifest);

  const auto own_watch = std::make_unique<RunWatch>();
  RunWatch& watch = request.watch != nullptr ? *request.watch : *own_watch;
  ProgressDisplay display(progress, watch, stop);
  bool is_journal_sound = true;
  FinishedRun finished = record_run({rig, machine, request, stop, watch}, journal, display, is_journal_sound);
  remover.run_has_begun();
  watch.phase = RunWatch::Phase::closing;
  display.show();
  LinesAfterRun lines(rig, finished);
  lines.during([&] { write_files(finished, folder, is_journal_sound ? &journal : nullptr, manifest); });
  lines.await_drop_out();
  display.rethrow_failure();
  return finished;
}

}  // namespace eha::play
