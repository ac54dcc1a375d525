// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/recovery.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "config/experiment_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/recover.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

/// Whether an experiment only places the rod, so that there is nothing to fit.
bool only_places(const Entry& entry) {
  try {
    return config::parse_experiment(entry.experiment, entry.file).placing() != nullptr;
  } catch (const Error&) {
    // Possibly a queue of another version: the fit reports the error.
    return false;
  }
}

void settle_running(Entry& entry, const fs::path& runs_folder, bool keeps_last_rows) {
  entry.state = EntryState::over;
  entry.exit_code = static_cast<int>(ExitCode::device_unavailable);
  entry.outcome = "lost";
  entry.note = "ehad ended before this run recorded anything; submit it again";
  const fs::path folder = runs_folder / entry.run;
  if (!entry.run.empty() && record::is_run_folder(folder)) {
    // Where its rows cannot be read, nobody knows.
    bool may_have_jumped = true;
    bool may_have_missed = true;
    try {
      const record::Manifest manifest = record::read_manifest(folder);
      entry.outcome = record::outcome_text(manifest);
      const bool is_torn =
          record::is_torn_run(folder) || (!keeps_last_rows && manifest.outcome == acquisition::Outcome::recovered);
      may_have_jumped = record::reading_jumped(manifest) || is_torn;
      may_have_missed = record::missed_motion(manifest) || is_torn;
      entry.note = "ehad ended during this run";
    } catch (const std::exception& error) {
      entry.note = fmt::format("ehad ended during this run, and the run cannot be read: {}", error.what());
    }
    entry.has_open_slip = entry.calibration && may_have_jumped;
    entry.missed_motion = entry.calibration && may_have_missed;
  }
  if (entry.outcome == acquisition::to_text(acquisition::Outcome::completed) ||
      entry.outcome == acquisition::to_text(acquisition::Outcome::precise_enough)) {
    // The run had ended by itself; only its queue entry was not saved.
    entry.state = only_places(entry) ? EntryState::over : EntryState::fitting;
    entry.exit_code = 0;
    entry.note.clear();
  }
  if (entry.state == EntryState::over) entry.experiment.clear();
  entry.is_open_fault = !entry.note.empty();
  const char* completed =
      entry.state == EntryState::fitting ? "it had completed and is fitted now" : "it had completed";
  spdlog::warn("experiment {} (\"{}\" of {}): was on when ehad ended: {}", entry.id, entry.name, entry.user,
               entry.note.empty() ? completed : entry.note);
}

/// Ends a move that had not begun: once the rig is armed again, it would begin unexpectedly.
void settle_waiting(Entry& entry) {
  if (!only_places(entry)) return;
  entry.state = EntryState::over;
  entry.exit_code = static_cast<int>(ExitCode::permission);
  entry.outcome = "refused";
  entry.note = "ehad ended before it began; a move to a place is never held: eha arm, then again";
  entry.experiment.clear();
}

/// Completes the entry of an experiment whose fit had ended before the program died; the others are fitted again.
void settle_fitting(Entry& entry, const fs::path& runs_folder) {
  const fs::path folder = runs_folder / entry.run;
  try {
    os::remove_temporary_files(folder);
    os::remove_temporary_files(folder / record::kModelsFolder);
    const record::Manifest manifest = record::read_manifest(folder);
    if (!manifest.identification) return;
    const bool accepted = manifest.identification->accepted;
    // Written after the manifest, so it may be missing.
    if (accepted && record::reason_against_latest(manifest).empty()) record::publish_latest(record::OpenRun(folder));
    entry.models = record::to_json(manifest.identification->models);
    entry.note = manifest.identification->error;
    const ExitCode code = accepted             ? ExitCode::ok
                          : entry.note.empty() ? ExitCode::model_rejected
                                               : ExitCode::not_converged;
    entry.exit_code = static_cast<int>(code);
    entry.state = EntryState::over;
    entry.experiment.clear();
    spdlog::info("experiment {}: had been fitted when ehad ended", entry.id);
  } catch (const std::exception& error) {
    spdlog::warn("experiment {}: {}; it is fitted again", entry.id, error.what());
  }
}

}  // namespace

void recover_runs(const fs::path& runs_folder, const std::function<void()>& before_each) {
  record::recover_torn_runs(runs_folder, {.before_each = before_each,
                                          .skipped = [](const std::string& message) { spdlog::warn("{}", message); },
                                          .recovered = [](const std::string& message) { spdlog::warn("{}", message); },
                                          .failed = [](const std::string& message) { spdlog::error("{}", message); }});
}

void settle(std::vector<Entry>& entries, const fs::path& runs_folder, bool keeps_last_rows) {
  for (Entry& entry : entries) {
    if (entry.state == EntryState::running) settle_running(entry, runs_folder, keeps_last_rows);
    if (entry.state == EntryState::fitting) settle_fitting(entry, runs_folder);
    if (entry.state == EntryState::waiting || entry.state == EntryState::held) settle_waiting(entry);
  }
}

Json models_of(const fs::path& run_folder) noexcept {
  try {
    return record::to_json(record::models_of(record::read_manifest(run_folder)));
  } catch (const std::exception&) {
    return Json::array();
  }
}

}  // namespace eha::service
