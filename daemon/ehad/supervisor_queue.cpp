// SPDX-License-Identifier: GPL-3.0-or-later
// The queue: experiments are checked and queued, held, released, moved and cancelled.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "config/experiment_config.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/ehad/supervisor.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/rig/narrower_limits.hpp"
#include "daemon/rig/ruler_check.hpp"
#include "hal/backends/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

bool is_queued(const Entry& entry) { return entry.state == EntryState::waiting || entry.state == EntryState::held; }

}  // namespace

void Supervisor::submit(const Peer& peer, control::SubmitCall call, Answer answer) {
  if (shutting_down_) throw DeviceError("ehad is stopping; submit again once it has restarted");
  if (call.fast && !hal::has_virtual_clock(rig_.config()->backend)) {
    throw UsageError(
        fmt::format("{}: virtual time is for simulated rigs; {} drives a real machine, which runs in real time only",
                    call.experiments.front().name, options_.rig_file));
  }
  require_room_in_queue(peer, call.experiments.size());
  submissions_[peer.uid] += call.experiments.size();
  auto submission = std::make_shared<Submission>();
  submission->uid = peer.uid;
  submission->is_list = call.is_list;
  submission->rig = rig_.config();
  submission->ruler_in = call.ruler_in;
  if (may_start(peer.uid)) submission->armed_at = holds_;
  submission->client = call.detach ? 0 : peer.client;
  submission->answer = std::move(answer);
  if (!call.detach) attached_[peer.client] = submission;
  for (control::SubmittedExperiment& experiment : call.experiments) {
    Entry entry;
    entry.id = queue_.take_id();
    entry.file = std::move(experiment.name);
    entry.uid = peer.uid;
    entry.user = peer.user;
    entry.fast = call.fast;
    entry.accept_travel_risk = call.accept_travel_risk;
    entry.is_for_machine = rig_.moves_machine();
    entry.submitted = record::utc_now();
    entry.experiment = std::move(experiment.text);
    submission->entries.push_back(std::move(entry));
  }
  const fs::path folder = check_folder(submission->entries.front().id).parent_path();
  disk_thread_.ask(
      [submission, folder, rig_file = options_.rig_file] {
        require_no_narrower_limits(*submission->rig, rig_file);
        for (Entry& entry : submission->entries) {
          // Finds errors of the text itself at once; reads no file that it names.
          const config::ExperimentConfig experiment = config::parse_experiment(entry.experiment, entry.file);
          entry.name = experiment.name;
          entry.only_places = experiment.placing() != nullptr;
          submission->characterises = submission->characterises || experiment.characterises();
          submission->moves_at_once = submission->moves_at_once || entry.only_places;
        }
        for (const Entry& entry : submission->entries) {
          write_checked_files(folder / std::to_string(entry.id), entry.experiment, *submission->rig);
        }
      },
      [this, submission](std::future<void> written) {
        try {
          written.get();
          require_arming_of_placing(*submission);
          require_ruler(*submission);
        } catch (const Error&) {
          refuse(*submission);
          return;
        }
        check(submission);
      });
}

void Supervisor::require_arming_of_placing(const Submission& submission) const {
  if (!submission.moves_at_once || may_still_start(submission)) return;
  const Entry& first = submission.entries.front();
  require_lease({.uid = submission.uid, .user = first.user}, first.file);
  if (may_start(submission.uid)) {
    throw PermissionError(
        fmt::format("{}: the rig was armed anew while this was checked, so that it may be for another purpose: submit "
                    "it again; a move to a place is never held",
                    first.file));
  }
  throw PermissionError(
      fmt::format("{}: the rig is not armed by {}{}: eha arm, then again; a move to a place is never held", first.file,
                  first.user, queue_.open_fault() != nullptr ? fmt::format(" ({})", disarmed_because_) : ""));
}

void Supervisor::require_ruler(const Submission& submission) const {
  if (!submission.characterises || !needs_ruler(*submission.rig)) return;
  require_agreement_with_ruler(submission.ruler_in, shown_in(), DisplayUnit(submission.rig->units));
}

double Supervisor::shown_in() const {
  const Json rod = rig_.rod();
  if (!rod.is_object()) throw DeviceError("the service has not read the rod yet; try again");
  if (rod.at("error").is_string()) throw DeviceError(rod.at("error").get<std::string>());
  return rod.at("displacement_in").get<double>();
}

void Supervisor::refuse(const Submission& submission) {
  end_submission(submission);
  submission.answer([failure = std::current_exception()]() -> Json { std::rethrow_exception(failure); });
}

std::optional<double> Supervisor::place_at_start() const {
  // Where the rod is on its way says nothing of where it will stand. A simulated one stands still between runs, a real
  // one where the previous experiment leaves it.
  if (active_ || (rig_.moves_machine() && queue_.count(EntryState::waiting) > 0)) return std::nullopt;
  const Json rod = rig_.rod();
  const auto place = rod.is_object() ? rod.find("displacement_in") : rod.end();
  return place != rod.end() && place->is_number() ? std::optional<double>(*place) : std::nullopt;
}

void Supervisor::check(const std::shared_ptr<Submission>& submission) {
  const Entry& entry = submission->entries[submission->checked];
  const fs::path folder = check_folder(entry.id);
  const auto place_in = submission->checked == 0 || !rig_.moves_machine() ? place_at_start() : std::nullopt;
  checker_.add({.user = submission->uid,
                .experiment = folder / kCheckedExperiment,
                .rig = folder / kCheckedRig,
                .place_in = place_in,
                .accept_travel_risk = entry.accept_travel_risk,
                .avoided_cpu = rig_.config()->realtime.cpu},
               [this, submission, folder, place_in](const worker::WorkerEnd& end) {
                 Entry& checked = submission->entries[submission->checked];
                 const bool goes_on = submission->findings.take(end, {folder / kCheckedExperiment, checked.file},
                                                                {folder / kCheckedRig, options_.rig_file});
                 checked.rehearsal = rehearsal_of(end);
                 checked.duration_s = duration_of(end);
                 checked.rehearsed = {submission->rig, place_in};
                 ++submission->checked;
                 if (goes_on && submission->checked < submission->entries.size()) {
                   check(submission);
                   return;
                 }
                 try {
                   submission->findings.throw_if_any();
                 } catch (const Error&) {
                   refuse(*submission);
                   return;
                 }
                 enqueue(submission);
               });
}

void Supervisor::end_submission(const Submission& submission) {
  auto& count = submissions_[submission.uid];
  count -= submission.entries.size();
  if (count == 0) submissions_.erase(submission.uid);
  if (submission.client != 0) attached_.erase(submission.client);
  for (const Entry& entry : submission.entries) remove_check_folder(check_folder(entry.id));
}

void Supervisor::remove_check_folder(const fs::path& folder) {
  disk_thread_.ask(
      [folder] {
        std::error_code ignored;
        fs::remove_all(folder, ignored);
      },
      [](std::future<void>) {});
}

void Supervisor::enqueue(const std::shared_ptr<Submission>& submission) {
  disk_thread_.ask(
      [this, submission] {
        std::size_t saved = 0;
        try {
          for (const Entry& entry : submission->entries) {
            store_.save(entry);
            ++saved;
          }
        } catch (const Error&) {
          for (std::size_t i = 0; i < saved; ++i) store_.remove(submission->entries[i].id);
          throw;
        }
      },
      [this, submission](std::future<void> saved) {
        const bool has_lost_client = submission->client != 0 && !attached_.contains(submission->client);
        end_submission(*submission);
        submission->answer([&]() -> Json {
          saved.get();
          try {
            if (has_lost_client) {
              // Nobody was told its number: whoever ended the command, by Ctrl-C for one, wants it no more.
              const Entry& first = submission->entries.front();
              spdlog::info("experiment {} (\"{}\" of {}): not queued: its command ended while it was checked", first.id,
                           first.name, first.user);
              throw DeviceError(fmt::format("{}: not queued: its command ended while it was checked", first.file));
            }
            // The rig may have been disarmed during the check.
            require_arming_of_placing(*submission);
          } catch (const Error&) {
            for (const Entry& entry : submission->entries) {
              disk_thread_.ask([this, id = entry.id] { store_.remove(id); }, [](std::future<void>) {});
            }
            throw;
          }
          std::vector<EntryId> ids;
          for (Entry& entry : submission->entries) {
            Entry& added = queue_.add(std::move(entry));
            // Only an experiment whose owner has armed the rig may start automatically.
            added.state = may_still_start(*submission) ? EntryState::waiting : EntryState::held;
            if (submission->armed_at && added.state == EntryState::held) {
              added.note = "the rig was disarmed while it was checked";
            }
            added.client = submission->client;
            spdlog::info("experiment {} (\"{}\" of {}): {}", added.id, added.name, added.user, to_text(added.state));
            ids.push_back(added.id);
          }
          if (lease_.is_held_by(submission->uid)) lease_.renew(Clock::now());
          start_next();
          if (!submission->is_list) return this->entry(ids.front());
          Json list = Json::array();
          for (const EntryId id : ids) list.push_back(this->entry(id));
          return {{"entries", std::move(list)}};
        });
      });
}

void Supervisor::client_gone(control::ClientId client) {
  attached_.erase(client);
  for (const auto& [id, entry] : queue_.entries()) {
    if (entry.client == client) hold_for_lost_client(*queue_.find(id));
  }
}

void Supervisor::hold_for_lost_client(Entry& entry) {
  entry.client = 0;
  if (active_ && active_->entry == entry.id && !active_->playing) active_->lost_client = true;
  if (!is_queued(entry)) return;
  if (entry.state == EntryState::held) return;  // for a reason that is known already
  const std::string why = "the connection of the command that submitted it was lost before it began";
  if (entry.only_places) {
    refuse_move(entry, why);
    return;
  }
  entry.state = EntryState::held;
  entry.note = why;
  spdlog::warn("experiment {}: held: {}", entry.id, entry.note);
  save(entry);
}

void Supervisor::refuse_move(Entry& entry, const std::string& why) {
  spdlog::warn("experiment {}: not run: {}", entry.id, why);
  entry.outcome = "refused";
  entry.note = fmt::format("{}; a move to a place is never held: eha arm, then again", why);
  close_entry(entry, ExitCode::permission);
}

void Supervisor::hold_waiting(const std::string& why) {
  ++holds_;
  std::vector<EntryId> moves;
  for (const auto& [id, entry] : queue_.entries()) {
    if (entry.state == EntryState::waiting && entry.only_places) moves.push_back(id);
  }
  for (const EntryId id : moves) refuse_move(*queue_.find(id), why);
  queue_.hold_waiting(why);
}

void Supervisor::require_room_in_queue(const Peer& peer, std::size_t wanted) const {
  const auto checking = submissions_.find(peer.uid);
  const std::size_t of_user = queue_.count_queued(peer.uid) + (checking == submissions_.end() ? 0 : checking->second);
  if (of_user + wanted > Queue::kMostQueuedOfUser) {
    throw IoError(
        fmt::format("{} experiments of {} are in the queue; one user may have {}, and this would be {} more; "
                    "eha queue cancel NUMBER removes one",
                    of_user, peer.user, Queue::kMostQueuedOfUser, wanted));
  }
  std::size_t all = queue_.count_queued();
  for (const auto& [uid, count] : submissions_) all += count;
  if (all + wanted > Queue::kMostQueued) {
    throw IoError(
        fmt::format("{} experiments are in the queue; it holds {}, and this would be {} more; eha queue "
                    "cancel NUMBER removes one",
                    all, Queue::kMostQueued, wanted));
  }
}

Entry& Supervisor::require_own(const Peer& peer, EntryId id, std::string_view what) {
  Entry* entry = queue_.find(id);
  if (entry == nullptr) throw UsageError(fmt::format("experiment {}: not in the queue", id));
  if (entry->uid != peer.uid && peer.uid != kRoot) {
    const std::string who = entry->uid == kRoot ? entry->user : entry->user + " and root";
    throw PermissionError(fmt::format("experiment {}: submitted by {}; only {} may {} it", id, entry->user, who, what));
  }
  if (!is_queued(*entry)) {
    throw UsageError(fmt::format("experiment {}: {}, not waiting{}", id, to_text(entry->state),
                                 entry->state == EntryState::running ? "; eha stop ends it" : ""));
  }
  if (lease_.is_held_by(peer.uid)) lease_.renew(Clock::now());
  return *entry;
}

Json Supervisor::hold(const Peer& peer, std::optional<EntryId> only) {
  std::vector<EntryId> ids = queue_.of(peer.uid, EntryState::waiting);
  if (only) {
    const Entry& entry = require_own(peer, *only, "hold");
    ids.clear();
    if (entry.state == EntryState::waiting) ids.push_back(*only);
  }
  for (const EntryId id : ids) {
    // After a restart every waiting entry is held: the file need not change.
    queue_.find(id)->state = EntryState::held;
    spdlog::info("experiment {}: held by {} (uid {}, pid {})", id, peer.user, peer.uid, peer.pid);
  }
  if (lease_.is_held_by(peer.uid)) lease_.renew(Clock::now());
  return {{"held", ids}};
}

Json Supervisor::release(const Peer& peer, std::optional<EntryId> only) {
  if (!lease_.is_held_by(peer.uid)) {
    require_lease(peer, "not released");
    throw PermissionError("not released: you do not hold the lease; eha arm first");
  }
  if (!may_start(peer.uid)) throw UsageError("not released: the rig is not armed; eha arm first");
  std::vector<EntryId> ids = queue_.of(peer.uid, EntryState::held);
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
    Entry& entry = *queue_.find(id);
    entry.state = EntryState::waiting;
    // Removes the note that the connection was lost: the owner has the experiment again.
    entry.note.clear();
    save(entry);
    spdlog::info("experiment {}: released by {} (uid {}, pid {})", id, peer.user, peer.uid, peer.pid);
  }
  lease_.renew(Clock::now());
  start_next();
  return {{"released", ids}};
}

void Supervisor::move(const Peer& peer, const control::MoveCall& call, Answer answer) {
  const Entry& moved = require_own(peer, call.entry, "move");
  const std::vector<EntryId> order = queue_.queued_of(moved.uid);
  const std::int64_t now = std::find(order.begin(), order.end(), call.entry) - order.begin() + 1;
  std::vector<Entry> changed;
  for (const EntryId id : queue_.move(call.entry, call.to > 0 ? call.to : now + call.by)) {
    changed.push_back(*queue_.find(id));
  }
  spdlog::info("experiment {}: moved by {}", call.entry, peer.user);
  disk_thread_.ask(
      [this, changed = std::move(changed)] {
        for (const Entry& entry : changed) store_.save(entry);
      },
      [this, id = call.entry, answer = std::move(answer)](std::future<void> saved) {
        answer([&]() -> Json {
          saved.get();
          return this->entry(id);
        });
      });
}

void Supervisor::cancel(const Peer& peer, EntryId id, Answer answer) {
  Entry& entry = require_own(peer, id, "cancel");
  entry.state = EntryState::cancelled;
  entry.note =
      fmt::format("cancelled by {} before it began: it is out of the queue, and nothing was played", peer.user);
  entry.exit_code = static_cast<int>(ExitCode::interrupted);
  entry.experiment.clear();
  spdlog::info("experiment {}: cancelled by {}", id, peer.user);
  disk_thread_.ask([this, copy = entry] { store_.save(copy); },
                   [described = this->entry(id), answer = std::move(answer)](std::future<void> saved) {
                     answer([&]() -> Json {
                       saved.get();
                       return described;
                     });
                   });
  forget_old(id);
}

}  // namespace eha::service
