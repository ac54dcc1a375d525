// SPDX-License-Identifier: GPL-3.0-or-later
// Start of the next experiment, after a rehearsal from the rod's present position.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <utility>

#include "config/experiment_config.hpp"
#include "config/file_kind.hpp"
#include "core/error.hpp"
#include "daemon/ehad/queued_play.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "daemon/rig/narrower_limits.hpp"
#include "daemon/rig/ruler_check.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

/// Whether an entry's rehearsal is for this rig and this position of the rod.
bool is_rehearsed(const Entry& entry, const RigKeeper::Config& rig, double place_in) {
  if (!entry.rehearsed || entry.rehearsed->rig != rig) return false;
  return entry.rehearsed->place_in && std::abs(place_in - *entry.rehearsed->place_in) <= kSamePlace_in;
}

/// Whether the rod is explored before the first row, as one whose valve is not known.
bool explores(const Entry& entry, const config::RigConfig& rig) {
  return !rig.limits.following && config::characterises(entry.experiment, entry.file);
}

/// A ruler's reading is compared with the sensor when the first measurement of a valve is submitted. It says nothing of
/// another rig file, nor of a rod that was moved since. @throws ConfigError
void require_ruler_still_valid(const Entry& entry, const config::RigConfig& rig) {
  if (!needs_ruler(rig) || !explores(entry, rig)) return;
  throw ConfigError(fmt::format(
      "{}: the rod stands elsewhere than when a ruler's reading was compared with the sensor, or the rig file was "
      "reloaded since: ask for it again (eha characterise), with a new reading",
      entry.file));
}

}  // namespace

Entry* Supervisor::whose_turn() {
  if (shutting_down_ || active_ || !lease_.holder() || !rig_.is_armed()) return nullptr;
  return queue_.next_of(lease_.holder()->uid);
}

void Supervisor::start_next() {
  if (next_) return;
  const Entry* entry = whose_turn();
  if (entry == nullptr) return;
  const fs::path folder = options_.state / "check" / fmt::format("start-{}", ++starts_);
  next_ = std::make_shared<const Start>(Start{.entry = entry->id, .folder = folder, .rig = rig_.config()});
  rig_.read_place([this, turn = next_](std::future<double> read) { rehearse_next(turn, std::move(read)); });
}

Entry* Supervisor::still_next(const Turn& turn) {
  if (turn != next_) return nullptr;
  Entry* entry = whose_turn();
  if (entry != nullptr && entry->id == turn->entry && turn->rig == rig_.config()) return entry;
  // Held, moved or cancelled meanwhile, or the rig was reloaded.
  next_.reset();
  start_next();
  return nullptr;
}

void Supervisor::rehearse_next(const Turn& turn, std::future<double> read) {
  poll_rod(Clock::now());
  Entry* entry = still_next(turn);
  if (entry == nullptr) return;
  if (rig_.moves_machine() && !entry->is_for_machine) {
    give_up(*entry, ExitCode::permission,
            "it was submitted for a simulated rig, where nobody confirms motion or what a rehearsal risks, and the rig "
            "is a machine now: submit it again");
    return;
  }
  double place_in = 0.0;
  try {
    place_in = read.get();
  } catch (const Error& error) {
    give_up(*entry, error.exit_code(), fmt::format("{}: not rehearsed before playing: {}", entry->file, error.what()));
    return;
  }
  if (is_rehearsed(*entry, turn->rig, place_in)) {
    start(*entry);
    return;
  }
  try {
    require_ruler_still_valid(*entry, *turn->rig);
  } catch (const Error& error) {
    give_up(*entry, error.exit_code(), error.what());
    return;
  }
  disk_thread_.ask([turn, text = entry->experiment] { write_checked_files(turn->folder, text, *turn->rig); },
                   [this, turn, place_in](std::future<void> written) {
                     Entry* written_for = still_next(turn);
                     if (written_for == nullptr) return remove_check_folder(turn->folder);
                     try {
                       written.get();
                     } catch (const Error& error) {
                       remove_check_folder(turn->folder);
                       give_up(*written_for, error.exit_code(), error.what());
                       return;
                     }
                     check_next(turn, place_in);
                   });
}

void Supervisor::check_next(const Turn& turn, double place_in) {
  checker_.add({.experiment = turn->folder / kCheckedExperiment,
                .rig = turn->folder / kCheckedRig,
                .place_in = place_in,
                .accept_travel_risk = queue_.find(turn->entry)->accept_travel_risk,
                .avoided_cpu = turn->rig->realtime.cpu,
                .is_urgent = true},
               [this, turn, place_in](const worker::WorkerEnd& end) { finish_rehearsal(turn, place_in, end); });
}

void Supervisor::finish_rehearsal(const Turn& turn, double place_in, const worker::WorkerEnd& end) {
  remove_check_folder(turn->folder);
  Entry* entry = still_next(turn);
  if (entry == nullptr) return;
  try {
    throw_if_failed(end, {turn->folder / kCheckedExperiment, entry->file},
                    {turn->folder / kCheckedRig, options_.rig_file});
  } catch (const Error& error) {
    const DisplayUnit unit(turn->rig->units);
    give_up(*entry, error.exit_code(),
            fmt::format("rehearsed before playing, from {:.3f} {}: {}", unit.factor("in") * place_in, unit.of("in"),
                        error.what()));
    return;
  }
  entry->rehearsal = rehearsal_of(end);
  entry->rehearsed = {turn->rig, place_in};
  start(*entry);
}

void Supervisor::start(Entry& entry) {
  next_.reset();
  if (rig_.guard() == GuardState::died) {
    rig_.mark_suspect();
    give_up(entry, ExitCode::device_unavailable,
            "the guard of the rig (eha-safe --guard) does not run, and nothing is driven without it; eha arm starts "
            "another");
    return;
  }
  entry.state = EntryState::running;
  if (rig_.moves_machine()) entry.calibration = rig_.calibration();
  active_.emplace(ActiveRun{.entry = entry.id,
                            .playing = false,
                            .watch = std::make_shared<play::RunWatch>(),
                            .stop = std::make_shared<acquisition::StopRequest>(),
                            .explores = explores(entry, *rig_.config())});
  active_->watch->samples = &rig_.samples();
  update_inhibitor();
  acquisition::Snapshot first;
  first.state = acquisition::State::armed;
  active_->watch->board.publish(first);
  // State `running` and the folder's name are saved before the rig moves, so a crash never replays an experiment.
  disk_thread_.ask(
      [this, entry, rig = rig_.config(), in_use = runs_in_use(), budget_GiB = config_.disk_budget_GiB]() mutable {
        require_no_narrower_limits(*rig, options_.rig_file);
        make_room(in_use, budget_GiB);
        const fs::path folder = record::create_run_folder(runs_folder(), entry.name);
        entry.run = folder.filename().string();
        index_->begin(entry.run, entry.uid);
        store_.save(entry);
        return folder;
      },
      [this, id = entry.id](std::future<fs::path> prepared) { begin(id, std::move(prepared)); });
}

void Supervisor::begin(EntryId id, std::future<fs::path> prepared) {
  Entry& entry = *queue_.find(id);
  fs::path folder;
  try {
    folder = prepared.get();
  } catch (const Error& error) {
    give_up(entry, error.exit_code(), error.what());
    return;
  }
  entry.run = folder.filename().string();
  // Its volts may take seconds to compute; meanwhile the rig's thread reads the lines.
  const RigKeeper::Config config = rig_.config_of_next_run();
  preparing_thread_.ask(
      [text = entry.experiment, file = entry.file, config] {
        return std::make_shared<const config::PreparedExperiment>(
            config::parse_prepared_experiment(text, file, *config));
      },
      [this, id, folder, config](std::future<Prepared> ready) { drive(id, folder, config, std::move(ready)); });
}

void Supervisor::drive(EntryId id, const fs::path& folder, const RigKeeper::Config& config,
                       std::future<Prepared> ready) {
  Entry& entry = *queue_.find(id);
  Prepared prepared;
  try {
    prepared = ready.get();
  } catch (const std::exception& error) {
    const auto* known = dynamic_cast<const Error*>(&error);
    remove_unplayed(entry, folder);
    give_up(entry, known != nullptr ? known->exit_code() : ExitCode::bug, error.what());
    return;
  }
  poll_rod(Clock::now());
  if (!active_->moved.empty()) {
    // A copy: giving up ends the run that holds it.
    const std::string why = active_->moved;
    remove_unplayed(entry, folder);
    give_up(entry, ExitCode::device_unavailable, why);
    return;
  }
  if (active_->lost_client) {
    take_back(entry, folder);
    return;
  }
  spdlog::info("experiment {} (\"{}\" of {}): runs in {}", id, entry.name, entry.user, folder.string());
  active_->playing = true;
  rig_.play(
      [this, entry, folder, config, prepared, watch = active_->watch, stop = active_->stop](
          OwnedRig* card, acquisition::StateMachine& machine, acquisition::EarlierRuns& earlier) {
        return play(entry, *prepared, folder, *config, card, rig_.rest(), rig_.snapshot(), options_.non_realtime,
                    machine, earlier, *stop, *watch);
      },
      [this, id](std::future<play::FinishedRun> played) { finish(id, std::move(played)); });
}

void Supervisor::remove_unplayed(Entry& entry, const fs::path& folder) {
  disk_thread_.ask(
      [folder] {
        std::error_code ignored;
        fs::remove_all(folder, ignored);
      },
      [](std::future<void>) {});
  account_for(std::exchange(entry.run, {}));
}

void Supervisor::take_back(Entry& entry, const fs::path& folder) {
  const bool was_stopped = active_->stop->count() > 0;
  active_.reset();
  remove_unplayed(entry, folder);
  entry.state = EntryState::waiting;
  hold_for_lost_client(entry);
  update_inhibitor();
  if (was_stopped) {
    disarm_rig("stopped before the run began", LeaseFate::kept);
  } else {
    start_next();
  }
}

}  // namespace eha::service
