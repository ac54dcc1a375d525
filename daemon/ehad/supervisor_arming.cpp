// SPDX-License-Identifier: GPL-3.0-or-later
// Rights to move the rig: arming, the lease, stops.
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/needs_following.hpp"
#include "core/error.hpp"
#include "daemon/ehad/supervisor.hpp"

namespace eha::service {
namespace {

constexpr std::string_view kPageUser = "eha-web";  // of its unit

/// Who has stopped a run, for its note.
std::string stopped_by(const control::StopCall& call, const std::string& user) {
  // A stop of one experiment alone comes from the command that follows it.
  if (!call.entry) return user == kPageUser ? "Stop on the page" : fmt::format("eha stop of {}", user);
  if (!call.signal) return fmt::format("the command of {}", user);
  if (*call.signal == SIGINT) return fmt::format("Ctrl-C of {}", user);
  const char* name = sigabbrev_np(*call.signal);
  return fmt::format("SIG{} to the command of {}", name != nullptr ? name : std::to_string(*call.signal), user);
}

}  // namespace

void Supervisor::require_lease(const Peer& peer, std::string_view what) const {
  const Lease::Holder* holder = lease_.holder();
  if (!holder || holder->uid == peer.uid || peer.uid == kRoot) return;
  const std::string whom = holder->uid == kRoot ? holder->user : holder->user + " or root";
  throw PermissionError(fmt::format("{}: {}; wait, or ask {} for eha disarm{}", what, holder_text(), whom,
                                    active_ ? " after it (eha stop, which anybody may give, ends it)" : ""));
}

std::string Supervisor::holder_text() const {
  const Lease::Holder& holder = *lease_.holder();
  std::string doing = "the rig is armed";
  if (active_) {
    // It keeps the lease, whose time begins anew with its end.
    const Entry& entry = queue_.entries().at(active_->entry);
    return fmt::format(
        "the lease is {}'s for {:.0f} s from the end of the run on (since {:%H:%M}; experiment {} \"{}\" of {} is "
        "being "
        "played)",
        holder.user, std::chrono::duration<double>(Lease::kDuration).count(),
        fmt::localtime(std::chrono::system_clock::to_time_t(holder.since)), entry.id, entry.name, entry.user);
  }
  if (!rig_.is_armed()) {
    doing = fmt::format("the rig is not armed: {}", why_disarmed());
  }
  return fmt::format("the lease is {}'s for another {:.0f} s (since {:%H:%M}; {})", holder.user,
                     lease_.remaining(Clock::now()).count(),
                     fmt::localtime(std::chrono::system_clock::to_time_t(holder.since)), doing);
}

bool Supervisor::may_start(uid_t uid) const {
  return lease_.is_held_by(uid) && !shutting_down_ && (active_ || rig_.is_armed());
}

bool Supervisor::may_still_start(const Submission& submission) const {
  return may_start(submission.uid) && submission.armed_at == holds_;
}

Json Supervisor::armed_answer(uid_t uid) const {
  Json held = Json::array();
  for (const EntryId id : queue_.of(uid, EntryState::held)) held.push_back(entry(id));
  Json remarks = Json::array();
  if (!rig_.moves_machine()) {
    remarks.push_back(
        "the rig is simulated: late ticks are counted, but the limits on them (realtime.abort_*) end no run");
  }
  const bool is_characterised = rig_.config()->limits.following.has_value();
  if (!is_characterised) {
    remarks.push_back(std::string(rig_.moves_machine() ? config::kNeedsFollowing : config::kNotFollowed));
  }
  return {{"state", acquisition::to_text(state())},
          {"lease_remaining_s", lease_.remaining(Clock::now()).count()},
          {"held", std::move(held)},
          {"characterised", is_characterised},
          {"remarks", std::move(remarks)}};
}

void Supervisor::require_no_slip() const {
  if (!rig_.moves_machine()) return;
  const Entry* slip = queue_.open_slip(rig_.calibration());
  if (slip == nullptr) return;
  throw Error(
      ExitCode::safety_trip,
      fmt::format("not armed: the sensor's reading jumped in experiment {}, or its rows cannot be read, and the rod "
                  "may stand elsewhere than "
                  "`eha read` shows: mend its holder or cable and hold a ruler to the rod; where both agree: `eha arm "
                  "--ruler LENGTH`; where not: `eha calibrate --sensor-moved` and its Next",
                  slip->id));
}

void Supervisor::require_no_missed_motion() const {
  constexpr std::size_t kMostMissed = 1;  // each costs some tenths of an inch that nothing measures
  if (!rig_.moves_machine()) return;
  const std::vector<EntryId> missed = queue_.missed_motion(rig_.calibration());
  if (missed.size() <= kMostMissed) return;
  throw Error(ExitCode::safety_trip,
              fmt::format("not armed: in experiments {} the rod did not do what the volts asked for, and each time it "
                          "may have moved unseen: look at sensor, valve, supply and [following], and hold a ruler to "
                          "the rod; where it agrees with `eha read`: `eha arm --ruler LENGTH`; where not: `eha "
                          "calibrate --sensor-moved` and its Next",
                          fmt::join(missed, ", ")));
}

void Supervisor::forget_missed_motion() {
  for (const EntryId id : queue_.forget_missed_motion(rig_.calibration())) save(*queue_.find(id));
}

void Supervisor::close_slips() {
  const std::vector<EntryId> changed = queue_.close_slips(rig_.calibration());
  for (const EntryId id : changed) save(*queue_.find(id));
  if (!changed.empty()) rig_.forget_slips();
}

void Supervisor::arm(const Peer& peer, const control::ArmCall& call, Answer answer) {
  if (shutting_down_) throw DeviceError("ehad is stopping; try again once it has restarted");
  require_lease(peer, "not armed");
  if (rig_.is_arming()) throw DeviceError("the rig is being armed already; see eha status");
  // Its limits are checked with the configuration that the runs will have.
  if (rig_.is_reconfiguring()) throw DeviceError("the configuration is being reloaded; try again");
  if (active_ && active_->stop->count() > 0) {
    throw DeviceError("not armed: a stop is ramping the rod out, and then disarms the rig; once it rests: eha arm");
  }
  if (!moved_at_rest_.empty() && !active_ && !rig_.is_armed()) {
    throw DeviceError(fmt::format("not armed: {}; then arm again", std::exchange(moved_at_rest_, {})));
  }
  if (!call.ruler_in && !active_ && !rig_.is_armed()) {
    require_no_slip();
    require_no_missed_motion();
  }
  const bool was_held = lease_.is_held_by(peer.uid);
  const bool takes_over = lease_.holder() && !was_held;
  if (takes_over && call.take_from != static_cast<std::int64_t>(lease_.holder()->uid)) {
    throw PermissionError(
        fmt::format("not armed: {}; `eha arm` of root asks before it takes the lease over, `eha arm "
                    "--yes` does not ask",
                    holder_text()));
  }
  if (takes_over) {
    spdlog::warn("the lease of {} is taken over by {} (uid {}, pid {})", lease_.holder()->user, peer.user, peer.uid,
                 peer.pid);
    hold_waiting(fmt::format("the lease was taken over by {}", peer.user));
  }
  const std::uint64_t grant = lease_.grant({peer.uid, peer.user}, Clock::now());
  if (active_ || rig_.is_armed()) {
    answer([&] { return armed_answer(peer.uid); });
    return;
  }
  const Entry* open_fault = queue_.open_fault();
  const std::string fault = open_fault != nullptr ? bad_end_of(*open_fault) : stopped_because_;
  const std::string run = open_fault != nullptr ? open_fault->run : "";
  auto done_arming = [this, peer, was_held, fault, run, grant, has_ruler = call.ruler_in.has_value(),
                      answer = std::move(answer)](std::future<void> done) {
    answer([&]() -> Json {
      try {
        done.get();
      } catch (...) {
        if (!was_held) lease_.take_back(grant);
        throw;
      }
      spdlog::info("armed by {} (uid {}, pid {}) for {} min", peer.user, peer.uid, peer.pid, Lease::kDuration.count());
      disarmed_because_.clear();
      stopped_because_.clear();
      if (rig_.moves_machine() && has_ruler) {
        close_slips();
        forget_missed_motion();
      }
      for (const EntryId id : queue_.close_faults()) save(*queue_.find(id));
      Json armed = armed_answer(peer.uid);
      if (!fault.empty()) armed["acknowledged"] = fault;
      if (!run.empty()) armed["acknowledged_run"] = run;
      return armed;
    });
  };
  rig_.arm(std::move(done_arming), call.ruler_in);
}

Json Supervisor::disarm(const Peer& peer) {
  require_lease(peer, "not disarmed");
  if (active_) throw UsageError("a run is on; eha stop ramps it out and disarms the rig");
  rig_.make_safe();
  if (lease_.holder()) disarm_rig(fmt::format("disarmed by {}", peer.user), LeaseFate::released);
  require_safe();
  return {{"state", acquisition::to_text(state())}};
}

void Supervisor::require_safe() const {
  if (rig_.is_unsafe()) throw DeviceError(std::string(kNotConfirmedSafe));
}

std::string Supervisor::why_disarmed() const {
  return rig_.is_unsafe() ? std::string(kNotConfirmedSafe) : disarmed_because_;
}

Json Supervisor::stop(const Peer& peer, const control::StopCall& call) {
  if (call.entry && (!active_ || active_->entry != *call.entry)) return {{"stopped", "nothing"}};
  if (active_) {
    active_->stop->request();
    const int count = active_->stop->count();
    if (active_->stopped_by.empty()) active_->stopped_by = stopped_by(call, peer.user);
    // Further stops change nothing, and a flood of them must not fill the log.
    if (count <= 2) {
      spdlog::warn("experiment {}: stop by {} (uid {}, pid {}): {}", active_->entry, peer.user, peer.uid, peer.pid,
                   count == 1 ? "ramping out" : "safe at once");
    }
    return {{"stopped", count == 1 ? "ramping_out" : "safe_at_once"}, {"entry", active_->entry}};
  }
  rig_.make_safe();
  const bool disarms = rig_.is_armed() || rig_.is_arming();
  if (disarms) disarm_rig(fmt::format("stopped by {}", peer.user), LeaseFate::kept);
  require_safe();
  return {{"stopped", disarms ? "disarmed" : "nothing"}};
}

void Supervisor::disarm_rig(const std::string& why, LeaseFate lease) {
  // An unacknowledged fault remains the reason, even if the rig is disarmed for another one.
  const Entry* fault = queue_.open_fault();
  disarmed_because_ = fault != nullptr ? bad_end_of(*fault) : why;
  if (lease == LeaseFate::kept) stopped_because_ = why;
  next_.reset();
  const Lease::Holder* holder = lease_.holder();
  const std::string kept =
      lease == LeaseFate::kept && holder ? fmt::format("; the lease stays with {}", holder->user) : "";
  if (lease == LeaseFate::released) lease_.release();
  rig_.cancel_arming();
  rig_.disarm();
  hold_waiting("the rig was disarmed before it began: " + why);
  const std::size_t held = queue_.count(EntryState::held);
  spdlog::info("disarmed: {}{}{}", why, kept, held > 0 ? fmt::format("; {} experiments are held", held) : "");
}

}  // namespace eha::service
