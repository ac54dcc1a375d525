// SPDX-License-Identifier: GPL-3.0-or-later
// Information for clients, and their actions on runs.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "config/characterisation.hpp"
#include "config/prepared_experiment.hpp"
#include "core/error.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"
#include "daemon/record/sha256.hpp"
#include "hal/backends/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;
using acquisition::Snapshot;

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
      {"lost_percent", acquisition::lost_percent(now)},
      {"dropped", now.counters.dropped},
      {"queue_peak", now.counters.queue_peak}};
}

/// One line for each run, oldest first.
Json list_of_runs(const fs::path& folder, const RunIndex& index) {
  Json list = Json::array();
  for (const fs::path& run : record::list_runs(folder)) {
    Json line{{"run", run.filename().string()}};
    try {
      line.update(to_json(record::summary_of(run.string(), record::read_manifest(run))));
    } catch (const std::exception& error) {
      line.update(to_json(record::RunSummary{.folder = run.string(), .outcome = "unreadable"}));
      line["error"] = error.what();
    }
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
                         ? Json(why_disarmed())
                         : Json(nullptr);
  const Entry* open_fault = queue_.open_fault();
  status["faulted_run"] = open_fault != nullptr && !open_fault->run.empty() ? Json(open_fault->run) : Json(nullptr);
  const config::RigConfig& rig = *rig_.config();
  status["rig"] = {{"name", rig.name},
                   {"file", options_.rig_file},
                   {"sha256", record::sha256_of(std::as_bytes(std::span(rig.text)))},
                   {"read_s", std::chrono::duration<double>(rig_read_.time_since_epoch()).count()},
                   {"backend", hal::name_of(rig.backend)},
                   {"moves", rig_.moves_machine()},
                   {"characterised", rig.limits.following.has_value()},
                   {"units", rig.units.empty() ? "in" : rig.units},
                   {"limits",
                    {{"travel_min_in", rig.limits.travel_min_in},
                     {"travel_max_in", rig.limits.travel_max_in},
                     {"command_min_V", rig.limits.command_min_V},
                     {"command_max_V", rig.limits.command_max_V},
                     {"velocity_limit_in_per_s", rig.limits.velocity_limit_in_per_s},
                     {"slew_V_per_s", rig.limits.slew_V_per_s},
                     {"placing_margin_in", config::placing_margin_in(rig)}}}};
  status["lease"] = nullptr;
  if (const Lease::Holder* holder = lease_.holder()) {
    status["lease"] = {{"uid", holder->uid},
                       {"user", holder->user},
                       {"remaining_s", std::ceil(lease_.remaining(Clock::now()).count())},
                       {"text", holder_text()}};
  }
  // Before its first tick a run has no reading of the rod; a while after its last one the reading is of the past.
  const bool is_over = active_ && active_->played && Clock::now() - *active_->played > RodView::kLongestAge;
  const bool has_ticked = active_ && active_->playing && active_->watch->board.read().counters.ticks > 0 && !is_over;
  status["rod"] = has_ticked ? rig_.rod(active_->watch->board.read()) : rig_.rod();
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
  if (active_ && active_->entry == id && active_->playing) {
    const Snapshot now = active_->watch->board.read();
    const double played_s = now.experiment_row * rig_.config()->realtime.sample_period_s;
    described["preparing_s"] = std::max(0.0, static_cast<double>(now.elapsed_ns) * 1e-9 - played_s);
    if (active_->explores && now.experiment_row == 0) described["exploring_at_most_s"] = config::kLongestExploring_s;
  }
  if (fitter_.entry() == id) {
    const Fitter::Spent spent = fitter_.spent();
    described["fitting_s"] = spent.elapsed_s;
    described["fitting_cpu_s"] = spent.cpu_s;
  }
  if (found->second.state == EntryState::waiting || found->second.state == EntryState::held) {
    const std::vector<EntryId> queued = queue_.queued_of(found->second.uid);
    described["position"] = std::find(queued.begin(), queued.end(), id) - queued.begin() + 1;
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
  if (next_ && next_->entry == entry.id) return "its rehearsal from where the rod stands now";
  if (entry.state == EntryState::waiting) return "the experiments before it";
  const std::string release = fmt::format("eha queue release {}", entry.id);
  std::string why = entry.note.empty() ? "" : ": " + entry.note;
  if (may_start(entry.uid)) return release + why;
  if (lease_.holder() && !lease_.is_held_by(entry.uid)) {
    return fmt::format("the lease of {}, then eha arm and {}{}", lease_.holder()->user, release, why);
  }
  if (why.empty() && queue_.open_fault() != nullptr) why = ": " + disarmed_because_;
  return fmt::format("eha arm, then {}{}", release, why);
}

Json Supervisor::queue(std::optional<std::int64_t> over) const {
  const std::vector<EntryId> ids = queue_.in_order();
  // The finished ones come first, the oldest of them at the beginning.
  const std::int64_t all_over = std::count_if(ids.begin(), ids.end(), [this](EntryId id) { return entry_is_over(id); });
  const std::int64_t left_out = std::max<std::int64_t>(0, all_over - over.value_or(all_over));
  Json list = Json::array();
  for (auto id = ids.begin() + left_out; id != ids.end(); ++id) list.push_back(entry(*id));
  return {{"entries", std::move(list)}, {"left_out", left_out}};
}

void Supervisor::runs(TextAnswer answer) {
  runs_asked_.push_back(std::move(answer));
  if (!is_listing_runs_) list_asked_runs();
}

void Supervisor::list_asked_runs() {
  is_listing_runs_ = true;
  disk_thread_.ask(
      [this, folder = runs_folder()] {
        const Json listed{{"folder", folder.string()}, {"runs", list_of_runs(folder, *index_)}};
        return std::make_shared<const std::string>(control::text_of(listed));
      },
      [this, answers = std::exchange(runs_asked_, {})](std::future<Text> read) {
        is_listing_runs_ = false;
        if (!runs_asked_.empty()) list_asked_runs();
        const std::shared_future<Text> listed = read.share();
        for (const TextAnswer& answer : answers) answer([&] { return listed.get(); });
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
  return fmt::format("{} ({}){}{}; next: eha arm", acquisition::to_text(rig_.state()), why_disarmed(), queue, fit);
}

}  // namespace eha::service
