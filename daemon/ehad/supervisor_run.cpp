// SPDX-License-Identifier: GPL-3.0-or-later
// Runs: an experiment that was played is fitted, and then over.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <set>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/shell_word.hpp"
#include "daemon/ehad/recovery.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;
using acquisition::Outcome;

constexpr double kBytesPerMiB = 1024.0 * 1024.0;
/// A run that asked for no motion, or saw none, says nothing of a sensor. Its noise is far below, and so is what is
/// missing of a sound rod.
constexpr double kSeenMotion_in = 0.2;

std::chrono::seconds whole_seconds(double seconds) { return std::chrono::seconds(static_cast<std::int64_t>(seconds)); }

/// Whether the card must be reopened after the run.
bool makes_card_suspect(const acquisition::RunReport& report) {
  return !report.safe_confirmed || acquisition::exit_code(report) == ExitCode::device_unavailable;
}

/// Whether the record of a run can say why it reached a limit (identify::trip_cause()), and so what to do: the list of
/// what is likely would be another answer.
bool shows_more_than_its_limit(const acquisition::RunReport& report) {
  using acquisition::Fault;
  const Fault fault = report.fault.fault;
  return (fault == Fault::travel_limit || fault == Fault::velocity_limit) &&
         report.fault.at_ns >= acquisition::kBegun_ns && !acquisition::reading_jumped(report.fault);
}

}  // namespace

void Supervisor::save(const Entry& entry) {
  disk_thread_.ask([this, entry] { store_.save(entry); },
                   [id = entry.id](std::future<void> saved) {
                     try {
                       saved.get();
                     } catch (const std::exception& error) {
                       spdlog::error("experiment {}: cannot save its queue entry: {}", id, error.what());
                     }
                   });
}

void Supervisor::finish(EntryId id, std::future<play::FinishedRun> played) {
  Entry& entry = *queue_.find(id);
  try {
    const play::FinishedRun run = played.get();
    conclude(entry, run);
  } catch (const RodMoved& error) {
    moved_at_rest_ = error.what();
    account_for(std::exchange(entry.run, {}));
    give_up(entry, error.exit_code(), error.what());
  } catch (const Error& error) {
    // Refused before the first tick; the folder has been removed.
    account_for(std::exchange(entry.run, {}));
    give_up(entry, error.exit_code(), error.what());
  } catch (const std::exception& error) {
    account_for(std::exchange(entry.run, {}));
    give_up(entry, ExitCode::bug, error.what());
  }
}

void Supervisor::give_up(Entry& entry, ExitCode code, const std::string& why) {
  spdlog::error("experiment {}: not run: {}", entry.id, why);
  active_.reset();
  entry.outcome = "refused";
  entry.note = why;
  close_entry(entry, code);
  disarm_rig(fmt::format("experiment {} could not be run", entry.id), LeaseFate::kept);
}

void Supervisor::conclude(Entry& entry, const play::FinishedRun& run) {
  const Outcome outcome = run.report.outcome;
  const bool was_stopped = active_->stop->count() > 0;
  const std::string stopped_by = active_->stopped_by;
  active_.reset();
  totals_.add(run.report);
  if (makes_card_suspect(run.report)) rig_.mark_suspect();
  if (!run.report.safe_confirmed && rig_.moves_machine()) rig_.close_unsafe();
  for (const std::string& sentence : run.report.realtime.refused) spdlog::warn("{}", sentence);
  entry.outcome = acquisition::to_text(outcome);
  entry.note = acquisition::describe(run.report, DisplayUnit(rig_.config()->units));
  if (!run.only_placed && shows_more_than_its_limit(run.report)) {
    entry.note = fmt::format("{}; `eha runs show {}` says what to do", record::without_remedy(entry.note),
                             shell_word(entry.run));
  }
  if (outcome == Outcome::interrupted && !stopped_by.empty()) entry.note += fmt::format(" ({})", stopped_by);
  if (outcome == Outcome::interrupted && stopped_by.empty() && shutting_down_) entry.note += " (ehad was ended)";
  const bool is_unguarded = rig_.guard() == GuardState::died;
  for (const std::string& sentence :
       {std::string(is_unguarded ? acquisition::kGuardDied : std::string_view()), run.write_error}) {
    if (!sentence.empty()) entry.note += (entry.note.empty() ? "" : "; ") + sentence;
  }
  entry.warnings = acquisition::warnings(
      run.report, run.only_placed ? acquisition::RunKind::placing : acquisition::RunKind::experiment);
  for (const delays::Delay& delay : run.delays) entry.warnings.push_back(delays::sentence_of(delay));
  const std::string circuit(acquisition::sentence_of(run.circuit));
  if (!circuit.empty()) entry.warnings.push_back(circuit);
  for (const std::string& sentence : entry.warnings) spdlog::warn("experiment {}: {}", entry.id, sentence);
  if (run.only_placed && std::isfinite(run.displacement_in)) {
    entry.placed_in = run.displacement_in;
    rig_.rod_is_at(run.displacement_in);
  }
  // A simulated rod says nothing of the machine's.
  if (acquisition::is_whole(outcome) && entry.calibration && run.report.moved_in > kSeenMotion_in) {
    forget_missed_motion();
  }
  if (acquisition::is_whole(outcome) && run.only_placed) {
    const DisplayUnit unit(rig_.config()->units);
    spdlog::info("experiment {}: the rod is at {:.3f} {}", entry.id, unit.factor("in") * run.displacement_in,
                 unit.of("in"));
    close_entry(entry, ExitCode::ok);
  } else if (acquisition::is_whole(outcome)) {
    spdlog::info("experiment {}: {}; {} ticks, {} of them late, {} more never ran, latency at most {:.0f} us", entry.id,
                 entry.outcome, run.report.counters.ticks, run.report.counters.late, run.report.counters.skipped,
                 static_cast<double>(run.report.latency.maximum_ns()) * 1e-3);
    entry.state = EntryState::fitting;
    save(entry);
    start_fit();
  } else {
    spdlog::error("experiment {}: {}: {}", entry.id, entry.outcome, entry.note);
    const bool is_guards_fault = is_unguarded && outcome == Outcome::interrupted;
    entry.is_open_fault = outcome != Outcome::interrupted;
    entry.has_open_slip = entry.calibration && acquisition::reading_jumped(run.report.fault);
    entry.missed_motion = entry.calibration && acquisition::names_motion(run.report.fault.fault);
    close_entry(entry, is_guards_fault ? ExitCode::device_unavailable : acquisition::exit_code(run.report));
  }
  lease_.renew(Clock::now());
  const bool goes_on = acquisition::is_whole(outcome) && !was_stopped && !is_unguarded && circuit.empty();
  if (goes_on && !shutting_down_ && rig_.rearm()) {
    start_next();
  } else {
    // After a stop or a fault the next experiment must not move the rig automatically.
    disarm_rig(!circuit.empty()                 ? circuit
               : acquisition::is_whole(outcome) ? fmt::format("experiment {}: stopped at its end", entry.id)
               : entry.is_open_fault            ? bad_end_of(entry)
                                                : fmt::format("experiment {}: {}", entry.id, entry.note),
               LeaseFate::kept);
  }
}

void Supervisor::close_entry(Entry& entry, ExitCode code) {
  entry.state = EntryState::over;
  entry.exit_code = static_cast<int>(code);
  entry.experiment.clear();
  save(entry);
  forget_old(entry.id);
  account_for(entry.run);
}

void Supervisor::forget_old(EntryId kept) {
  for (const EntryId old : queue_.forget_old(kept)) {
    disk_thread_.ask([this, old] { store_.remove(old); }, [](std::future<void>) {});
  }
}

void Supervisor::start_fit() {
  if (fitter_.entry() || shutting_down_) return;
  Entry* entry = queue_.next_to_fit();
  if (entry == nullptr) return;
  worker::WorkerLimits limits;
  limits.cpu_time = whole_seconds(config_.worker_cpu_time_s);
  limits.wall_time = whole_seconds(config_.worker_wall_time_s);
  limits.memory_bytes = static_cast<std::uint64_t>(config_.worker_memory_MiB * kBytesPerMiB);
  limits.avoided_cpu = rig_.config()->realtime.cpu;
  try {
    spdlog::info("experiment {}: being fitted by process {}", entry->id,
                 fitter_.start(entry->id, runs_folder() / entry->run, limits));
  } catch (const Error& error) {
    finish_fit(entry->id, {std::nullopt, error.what()});
  }
}

void Supervisor::poll_worker() {
  checker_.poll();
  if (const std::optional<EndedFit> ended = fitter_.poll()) finish_fit(ended->entry, ended->end);
  start_fit();
}

void Supervisor::finish_fit(EntryId id, const worker::WorkerEnd& end) {
  Entry& fitted = *queue_.find(id);
  fitted.state = EntryState::judging;
  disk_thread_.ask([folder = runs_folder() / fitted.run, end] { return conclude_fit(folder, end); },
                   [this, id](std::future<FitConclusion> concluded) {
                     Entry& entry = *queue_.find(id);
                     const FitConclusion fit = concluded.get();
                     entry.models = fit.models;
                     entry.note = fit.note;
                     if (fit.fitted) {
                       // A characterisation has no models: its valve sheet is in the run's folder.
                       spdlog::info("experiment {}: {}", id,
                                    fit.models.empty()         ? "evaluated"
                                    : fit.code == ExitCode::ok ? "fitted, a model is accepted"
                                                               : "fitted, no model is accepted");
                     } else {
                       ++totals_.worker_failures;
                       spdlog::error("experiment {}: not fitted: {}; the record is kept, `eha fit {}` repeats it", id,
                                     fit.note, shell_word((runs_folder() / entry.run).string()));
                     }
                     if (!fit.manifest_error.empty()) {
                       spdlog::error("experiment {}: cannot record in its manifest that it was not fitted: {}", id,
                                     fit.manifest_error);
                     }
                     close_entry(entry, fit.code);
                   });
}

std::set<std::string> Supervisor::runs_in_use() const {
  std::set<std::string> runs;
  for (const auto& [id, entry] : queue_.entries()) {
    if (entry.state != EntryState::over && !entry.run.empty()) runs.insert(entry.run);
  }
  return runs;
}

void Supervisor::make_room(const std::set<std::string>& in_use, double budget_GiB) {
  const Retention retention = index_->keep_within(static_cast<std::uint64_t>(budget_GiB * kBytesPerGiB), in_use);
  for (const RemovedRun& run : retention.removed) {
    spdlog::warn("run {}: removed ({:.1f} MB, no accepted model): the runs exceed the budget of {} GiB", run.name,
                 static_cast<double>(run.bytes) * 1e-6, budget_GiB);
  }
  if (!retention.refusal.empty()) throw IoError(retention.refusal);
}

void Supervisor::account_for(const std::string& run) {
  if (run.empty()) return;
  disk_thread_.ask(
      [this, run, in_use = runs_in_use(), budget_GiB = config_.disk_budget_GiB] {
        index_->update(run);
        make_room(in_use, budget_GiB);
      },
      [](std::future<void> done) {
        try {
          done.get();
        } catch (const std::exception& error) {
          spdlog::warn("the next run will be refused: {}", error.what());
        }
      });
}

}  // namespace eha::service
