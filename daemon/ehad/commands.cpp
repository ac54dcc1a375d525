// SPDX-License-Identifier: GPL-3.0-or-later
// What waits, and what clients are told.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.hpp"
#include "daemon/ehad/play.hpp"
#include "daemon/ehad/recovery.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "hal/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;
using acquisition::Snapshot;

Json describe(const Snapshot& now, double step_s) {
  return {{"elapsed_s", static_cast<double>(now.elapsed_ns) * 1e-9},
          {"experiment_s", now.experiment_row * step_s},
          {"experiment_total_s", now.experiment_rows * step_s},
          {"requested_V", now.requested_V},
          {"applied_V", now.applied_V},
          {"displacement_in", now.displacement_in},
          {"velocity_in_per_s", now.velocity_in_per_s},
          {"latency_max_us", static_cast<double>(now.latency_max_ns) * 1e-3},
          {"execution_max_us", static_cast<double>(now.execution_max_ns) * 1e-3},
          {"ticks", now.counters.ticks},
          {"late", now.counters.late},
          {"skipped", now.counters.skipped},
          {"dropped", now.counters.dropped},
          {"queue_peak", now.counters.queue_peak}};
}

/// One line for each run, oldest first.
Json list_of_runs(const fs::path& folder) {
  Json list = Json::array();
  for (const fs::path& run : record::list_runs(folder)) {
    Json line{{"run", run.filename().string()}, {"folder", run.string()}, {"outcome", "unreadable"}};
    try {
      line["outcome"] = record::read_manifest(run).at("outcome");
    } catch (const std::exception& error) {
      line["error"] = error.what();
    }
    line["models"] = models_of(run);
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
                   {"moves", rig_.moves_machine()}};
  status["lease"] = nullptr;
  if (const Lease::Holder* holder = lease_.holder()) {
    status["lease"] = {{"uid", holder->uid},
                       {"user", holder->user},
                       {"remaining_s", std::ceil(lease_.remaining(Clock::now()).count())}};
  }
  status["run"] = nullptr;
  if (active_) {
    status["run"] = entry(active_->entry);
    status["run"].update(describe(active_->watch->board.read(), rig.realtime.sample_period_s));
  }
  status["waiting"] = queue_.count(EntryState::waiting);
  status["worker"] = fitter_.entry() ? entry(*fitter_.entry()) : Json(nullptr);
  return status;
}

Json Supervisor::entry(EntryId id) const {
  const auto found = queue_.entries().find(id);
  if (found == queue_.entries().end()) return nullptr;
  Json described = service::describe(found->second);
  if (!found->second.run.empty()) described["folder"] = (runs_folder() / found->second.run).string();
  if (found->second.state == EntryState::waiting) described["waits_for"] = waiting_reason(found->second);
  return described;
}

bool Supervisor::entry_is_over(EntryId id) const {
  const auto found = queue_.entries().find(id);
  return found == queue_.entries().end() || found->second.state == EntryState::over ||
         found->second.state == EntryState::cancelled;
}

std::string Supervisor::waiting_reason(const Entry& entry) const {
  if (!lease_.holder()) return fmt::format("the rig to be armed by {} (eha arm)", entry.user);
  if (!lease_.is_held_by(entry.uid)) {
    return fmt::format("the lease, which {} holds; then {} must arm", lease_.holder()->user, entry.user);
  }
  return "the experiments before it";
}

Json Supervisor::queue() const {
  Json list = Json::array();
  for (const auto& [id, unused] : queue_.entries()) list.push_back(entry(id));
  return {{"entries", std::move(list)}};
}

void Supervisor::submit(const Peer& peer, control::SubmitCall call, Answer answer) {
  if (shutting_down_) throw DeviceError("ehad is stopping; submit again once it has restarted");
  if (queue_.count(EntryState::waiting) + submissions_ >= Queue::kMostWaiting) {
    throw IoError(fmt::format("{} experiments wait already; eha runs cancel NUMBER removes one", Queue::kMostWaiting));
  }
  ++submissions_;
  Entry entry;
  entry.id = queue_.take_id();
  entry.file = std::move(call.name);
  entry.uid = peer.uid;
  entry.user = peer.user;
  entry.fast = call.fast;
  entry.submitted = record::utc_now();
  entry.experiment = std::move(call.experiment);
  disk_thread_.ask(
      [this, entry = std::move(entry), config = rig_.config()]() mutable {
        entry.name = check_experiment(entry.experiment, entry.file, entry.fast, *config).name;
        store_.save(entry);
        return entry;
      },
      [this, answer = std::move(answer)](std::future<Entry> checked) {
        --submissions_;
        answer([&]() -> Json {
          const Entry& added = queue_.add(checked.get());
          spdlog::info("experiment {} (\"{}\" of {}): queued", added.id, added.name, added.user);
          if (lease_.is_held_by(added.uid)) lease_.renew(Clock::now());
          const EntryId id = added.id;
          start_next();
          return this->entry(id);
        });
      });
}

void Supervisor::cancel(const Peer& peer, EntryId id, Answer answer) {
  Entry* entry = queue_.find(id);
  if (entry == nullptr) throw UsageError(fmt::format("experiment {}: not in the queue", id));
  if (entry->uid != peer.uid) {
    throw PermissionError(
        fmt::format("experiment {}: submitted by {}; only {} may cancel it", id, entry->user, entry->user));
  }
  if (entry->state != EntryState::waiting) {
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
  disk_thread_.ask([folder = runs_folder()] { return list_of_runs(folder); },
                   [folder = runs_folder(), answer = std::move(answer)](std::future<Json> listed) {
                     answer([&]() -> Json { return {{"folder", folder.string()}, {"runs", listed.get()}}; });
                   });
}

std::string Supervisor::metrics() const {
  MetricsFacts facts;
  facts.state = state();
  facts.waiting = queue_.count(EntryState::waiting);
  if (lease_.holder()) facts.lease_remaining_s = lease_.remaining(Clock::now()).count();
  facts.worker_busy = fitter_.entry().has_value();
  if (active_) facts.snapshot = active_->watch->board.read();
  return metrics_text(totals_, facts);
}

std::string Supervisor::status_text() const {
  const std::size_t waiting = queue_.count(EntryState::waiting);
  const std::string queue = waiting > 0 ? fmt::format(", {} waiting", waiting) : "";
  const std::string fit = fitter_.entry() ? fmt::format(", fitting {}", *fitter_.entry()) : "";
  if (active_) {
    const Entry& entry = queue_.entries().at(active_->entry);
    return fmt::format("{}: experiment {} \"{}\" of {}{}{}", acquisition::to_text(state()), entry.id, entry.name,
                       entry.user, queue, fit);
  }
  if (lease_.holder()) return fmt::format("armed by {}{}{}", lease_.holder()->user, queue, fit);
  return fmt::format("{} ({}){}{}; next: eha arm", acquisition::to_text(rig_.state()), disarmed_because_, queue, fit);
}

}  // namespace eha::service
