// SPDX-License-Identifier: GPL-3.0-or-later
// What waits, and what clients are told.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "config/experiment_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/ehad/recovery.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "hal/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;
using acquisition::Snapshot;

constexpr const char* kCheckedExperiment = "experiment.toml";
constexpr const char* kCheckedRig = "rig.toml";

Json describe(const Snapshot& now, double step_s) {
  return {
      {"elapsed_s", static_cast<double>(now.elapsed_ns) * 1e-9},
      {"experiment_s", now.experiment_row * step_s},
      {"experiment_total_s", now.experiment_rows * step_s},
      {"requested_V", now.requested_V},
      {"applied_V", now.applied_V},
      {"displacement_in", now.displacement_in},
      {"velocity_in_per_s", now.velocity_in_per_s},
      {"travel_percent", 100.0 * now.travel_share},
      {"velocity_percent", 100.0 * now.velocity_share},
      {"near_limit", now.travel_share > acquisition::kWarningShare || now.velocity_share > acquisition::kWarningShare},
      {"latency_max_us", static_cast<double>(now.latency_max_ns) * 1e-3},
      {"execution_max_us", static_cast<double>(now.execution_max_ns) * 1e-3},
      {"ticks", now.counters.ticks},
      {"late", now.counters.late},
      {"skipped", now.counters.skipped},
      {"dropped", now.counters.dropped},
      {"queue_peak", now.counters.queue_peak}};
}

/// One line for each run, oldest first.
Json list_of_runs(const fs::path& folder, const RunIndex& index) {
  Json list = Json::array();
  for (const fs::path& run : record::list_runs(folder)) {
    Json line{{"run", run.filename().string()}, {"folder", run.string()}, {"outcome", "unreadable"}};
    try {
      line["outcome"] = record::outcome_text(record::read_manifest(run));
    } catch (const std::exception& error) {
      line["error"] = error.what();
    }
    line["models"] = models_of(run);
    const auto known = index.runs().find(run.filename().string());
    if (known != index.runs().end()) {
      line["sequence"] = known->second.sequence;
      line["acknowledged"] = known->second.acknowledged;
    }
    list.push_back(std::move(line));
  }
  return list;
}

}  // namespace

acquisition::State Supervisor::state() const { return active_ ? active_->watch->board.read().state : rig_.state(); }

Json Supervisor::status() const {
  Json status{{"ehad", EHA_VERSION}, {"state", acquisition::to_text(state())}};
  status["reason"] = state() == acquisition::State::faulted || state() == acquisition::State::idle
                         ? Json(disarmed_because_)
                         : Json(nullptr);
  const config::RigConfig& rig = *rig_.config();
  status["rig"] = {{"name", rig.name},
                   {"file", options_.rig_file},
                   {"backend", hal::name_of(rig.backend)},
                   {"moves", rig_.moves_machine()},
                   {"units", rig.units.empty() ? "in" : rig.units},
                   {"limits",
                    {{"travel_min_in", rig.limits.travel_min_in},
                     {"travel_max_in", rig.limits.travel_max_in},
                     {"command_min_V", rig.limits.command_min_V},
                     {"command_max_V", rig.limits.command_max_V}}}};
  status["lease"] = nullptr;
  if (const Lease::Holder* holder = lease_.holder()) {
    status["lease"] = {{"uid", holder->uid},
                       {"user", holder->user},
                       {"remaining_s", std::ceil(lease_.remaining(Clock::now()).count())}};
  }
  status["rod"] = active_ && active_->playing ? rig_.rod(active_->watch->board.read()) : rig_.rod();
  status["run"] = nullptr;
  if (active_) {
    status["run"] = entry(active_->entry);
    status["run"].update(describe(active_->watch->board.read(), rig.realtime.sample_period_s));
  }
  status["waiting"] = queue_.count(EntryState::waiting);
  status["held"] = queue_.count(EntryState::held);
  status["worker"] = fitter_.entry() ? entry(*fitter_.entry()) : Json(nullptr);
  return status;
}

Json Supervisor::entry(EntryId id) const {
  const auto found = queue_.entries().find(id);
  if (found == queue_.entries().end()) return nullptr;
  Json described = service::describe(found->second);
  if (!found->second.run.empty()) described["folder"] = (runs_folder() / found->second.run).string();
  if (found->second.state == EntryState::waiting || found->second.state == EntryState::held) {
    described["waits_for"] = waiting_reason(found->second);
  }
  return described;
}

bool Supervisor::entry_is_over(EntryId id) const {
  const auto found = queue_.entries().find(id);
  return found == queue_.entries().end() || found->second.state == EntryState::over ||
         found->second.state == EntryState::cancelled;
}

std::string Supervisor::waiting_reason(const Entry& entry) const {
  if (entry.state == EntryState::waiting) return "the experiments before it";
  const std::string release = fmt::format("eha queue release {}", entry.id);
  if (may_start(entry.uid)) return fmt::format("its release by {} ({})", entry.user, release);
  if (lease_.holder() && !lease_.is_held_by(entry.uid)) {
    return fmt::format("the lease, which {} holds; then {} must arm (eha arm) and release it ({})",
                       lease_.holder()->user, entry.user, release);
  }
  return fmt::format("the rig to be armed by {} (eha arm), then its release ({})", entry.user, release);
}

Json Supervisor::queue() const {
  Json list = Json::array();
  for (const auto& [id, unused] : queue_.entries()) list.push_back(entry(id));
  return {{"entries", std::move(list)}};
}

void Supervisor::submit(const Peer& peer, control::SubmitCall call, Answer answer) {
  if (shutting_down_) throw DeviceError("ehad is stopping; submit again once it has restarted");
  if (call.fast && !hal::has_virtual_clock(rig_.config()->backend)) {
    throw UsageError(
        fmt::format("{}: virtual time is for simulated rigs; {} drives a real machine, which keeps its own", call.name,
                    options_.rig_file));
  }
  require_room_in_queue(peer);
  ++submissions_[peer.uid];
  auto entry = std::make_shared<Entry>();
  entry->id = queue_.take_id();
  entry->file = std::move(call.name);
  entry->uid = peer.uid;
  entry->user = peer.user;
  entry->fast = call.fast;
  entry->submitted = record::utc_now();
  entry->experiment = std::move(call.experiment);
  const fs::path folder = check_folder(entry->id);
  disk_thread_.ask(
      [entry, folder, rig = rig_.config()] {
        // Faults of the text itself are found here, at once, and no file that it names is read.
        entry->name = config::parse_experiment(entry->experiment, entry->file).name;
        os::create_folders(folder);
        os::write_file_atomically(folder / kCheckedExperiment, entry->experiment);
        os::write_file_atomically(folder / kCheckedRig, rig->text);
      },
      [this, entry, answer = std::move(answer)](std::future<void> written) {
        try {
          written.get();
        } catch (const Error&) {
          end_submission(*entry);
          answer([failure = std::current_exception()]() -> Json { std::rethrow_exception(failure); });
          return;
        }
        check(entry, answer);
      });
}

void Supervisor::check(std::shared_ptr<Entry> entry, Answer answer) {
  const fs::path folder = check_folder(entry->id);
  checker_.add(
      folder / kCheckedExperiment, folder / kCheckedRig, rig_.config()->realtime.cpu,
      [this, entry, folder, answer = std::move(answer)](const worker::WorkerEnd& end) {
        try {
          throw_if_failed(end, {folder / kCheckedExperiment, entry->file}, {folder / kCheckedRig, options_.rig_file});
        } catch (const Error&) {
          end_submission(*entry);
          answer([failure = std::current_exception()]() -> Json { std::rethrow_exception(failure); });
          return;
        }
        enqueue(entry, answer);
      });
}

void Supervisor::end_submission(const Entry& entry) {
  if (--submissions_[entry.uid] == 0) submissions_.erase(entry.uid);
  disk_thread_.ask(
      [folder = check_folder(entry.id)] {
        std::error_code ignored;
        fs::remove_all(folder, ignored);
      },
      [](std::future<void>) {});
}

void Supervisor::enqueue(std::shared_ptr<Entry> entry, const Answer& answer) {
  disk_thread_.ask([this, entry] { store_.save(*entry); },
                   [this, entry, answer](std::future<void> saved) {
                     end_submission(*entry);
                     answer([&]() -> Json {
                       saved.get();
                       Entry& added = queue_.add(std::move(*entry));
                       // Only an experiment whose owner has the armed rig may start by itself.
                       added.state = may_start(added.uid) ? EntryState::waiting : EntryState::held;
                       spdlog::info("experiment {} (\"{}\" of {}): {}", added.id, added.name, added.user,
                                    to_text(added.state));
                       if (lease_.is_held_by(added.uid)) lease_.renew(Clock::now());
                       const EntryId id = added.id;
                       start_next();
                       return this->entry(id);
                     });
                   });
}

void Supervisor::require_room_in_queue(const Peer& peer) const {
  const auto checking = submissions_.find(peer.uid);
  const std::size_t of_user = queue_.count_queued(peer.uid) + (checking == submissions_.end() ? 0 : checking->second);
  if (of_user >= Queue::kMostQueuedOfUser) {
    throw IoError(
        fmt::format("{} experiments of {} are in the queue, the most that one user may have; eha runs cancel "
                    "NUMBER removes one",
                    of_user, peer.user));
  }
  std::size_t all = queue_.count_queued();
  for (const auto& [uid, count] : submissions_) all += count;
  if (all >= Queue::kMostQueued) {
    throw IoError(fmt::format(
        "{} experiments are in the queue, the most that it holds; eha runs cancel NUMBER removes one", all));
  }
}

Json Supervisor::release(const Peer& peer, std::optional<EntryId> only) {
  if (!lease_.is_held_by(peer.uid)) {
    require_lease(peer, "not released");
    throw PermissionError("not released: you do not hold the lease; eha arm first");
  }
  if (!may_start(peer.uid)) throw UsageError("not released: the rig is not armed; eha arm first");
  std::vector<EntryId> ids = queue_.held_of(peer.uid);
  if (only) {
    const Entry* entry = queue_.find(*only);
    if (entry == nullptr) throw UsageError(fmt::format("experiment {}: not in the queue", *only));
    if (entry->uid != peer.uid) {
      throw PermissionError(
          fmt::format("experiment {}: submitted by {}; only {} may release it", *only, entry->user, entry->user));
    }
    if (entry->state != EntryState::held) {
      throw UsageError(fmt::format("experiment {}: {}, not held", *only, to_text(entry->state)));
    }
    ids = {*only};
  }
  for (const EntryId id : ids) {
    queue_.find(id)->state = EntryState::waiting;
    spdlog::info("experiment {}: released by {} (uid {}, pid {})", id, peer.user, peer.uid, peer.pid);
  }
  lease_.renew(Clock::now());
  start_next();
  return {{"released", ids}};
}

void Supervisor::cancel(const Peer& peer, EntryId id, Answer answer) {
  Entry* entry = queue_.find(id);
  if (entry == nullptr) throw UsageError(fmt::format("experiment {}: not in the queue", id));
  if (entry->uid != peer.uid && peer.uid != kRoot) {
    throw PermissionError(
        fmt::format("experiment {}: submitted by {}; only {} and root may cancel it", id, entry->user, entry->user));
  }
  if (entry->state != EntryState::waiting && entry->state != EntryState::held) {
    throw UsageError(fmt::format("experiment {}: {}, not waiting{}", id, to_text(entry->state),
                                 entry->state == EntryState::running ? "; eha stop ends it" : ""));
  }
  if (lease_.is_held_by(peer.uid)) lease_.renew(Clock::now());
  entry->state = EntryState::cancelled;
  entry->note = fmt::format("cancelled by {}", peer.user);
  entry->exit_code = static_cast<int>(ExitCode::interrupted);
  entry->experiment.clear();
  spdlog::info("experiment {}: cancelled by {}", id, peer.user);
  disk_thread_.ask([this, copy = *entry] { store_.save(copy); },
                   [this, id, answer = std::move(answer)](std::future<void> saved) {
                     answer([&]() -> Json {
                       saved.get();
                       return this->entry(id);
                     });
                   });
}

void Supervisor::runs(Answer answer) {
  disk_thread_.ask([this, folder = runs_folder()] { return list_of_runs(folder, *index_); },
                   [folder = runs_folder(), answer = std::move(answer)](std::future<Json> listed) {
                     answer([&]() -> Json { return {{"folder", folder.string()}, {"runs", listed.get()}}; });
                   });
}

void Supervisor::acknowledge(const Peer& peer, const std::string& run, Answer answer) {
  disk_thread_.ask([this, run] { index_->acknowledge(run); },
                   [peer, run, answer = std::move(answer)](std::future<void> done) {
                     answer([&]() -> Json {
                       done.get();
                       spdlog::info("run {}: acknowledged by {} (uid {}, pid {})", run, peer.user, peer.uid, peer.pid);
                       return {{"run", run}, {"acknowledged", true}};
                     });
                   });
}

void Supervisor::remove(const Peer& peer, const std::string& run, Answer answer) {
  if (runs_in_use().contains(run)) throw UsageError(fmt::format("{}: the run is on, or being fitted", run));
  disk_thread_.ask([this, run, uid = peer.uid] { return index_->remove(run, uid); },
                   [peer, run, answer = std::move(answer)](std::future<std::uint64_t> done) {
                     answer([&]() -> Json {
                       const std::uint64_t bytes = done.get();
                       spdlog::warn("run {}: removed by {} (uid {}, pid {})", run, peer.user, peer.uid, peer.pid);
                       return {{"run", run}, {"bytes", bytes}};
                     });
                   });
}

std::string Supervisor::metrics() const {
  MetricsFacts facts;
  facts.state = state();
  facts.waiting = queue_.count_queued();
  facts.held = queue_.count(EntryState::held);
  if (lease_.holder()) facts.lease_remaining_s = lease_.remaining(Clock::now()).count();
  facts.worker_busy = fitter_.entry().has_value();
  if (active_) facts.snapshot = active_->watch->board.read();
  return metrics_text(totals_, facts);
}

std::string Supervisor::status_text() const {
  const std::size_t queued = queue_.count_queued();
  const std::string queue = queued > 0 ? fmt::format(", {} in the queue", queued) : "";
  const std::string fit = fitter_.entry() ? fmt::format(", fitting {}", *fitter_.entry()) : "";
  if (active_) {
    const Entry& entry = queue_.entries().at(active_->entry);
    return fmt::format("{}: experiment {} \"{}\" of {}{}{}", acquisition::to_text(state()), entry.id, entry.name,
                       entry.user, queue, fit);
  }
  if (lease_.holder() && rig_.is_armed()) return fmt::format("armed by {}{}{}", lease_.holder()->user, queue, fit);
  return fmt::format("{} ({}){}{}; next: eha arm", acquisition::to_text(rig_.state()), disarmed_because_, queue, fit);
}

}  // namespace eha::service
