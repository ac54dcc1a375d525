// SPDX-License-Identifier: GPL-3.0-or-later
// Rights to move the rig: arming, the lease, stops, shutdown.
#include "daemon/ehad/supervisor.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "config/needs_following.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "daemon/ehad/recovery.hpp"
#include "daemon/rig/ruler_check.hpp"
#include "hal/backends/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kTimeToRecover{600};
constexpr std::chrono::seconds kSilence{10};  ///< after a message on motion at rest

fs::path require_program(const char* name) {
  fs::path program = find_program(name);
  if (program.empty()) {
    throw ConfigError(fmt::format("{}: not found beside ehad; install the whole package", name));
  }
  return program;
}

/// Who has stopped a run, for its note.
std::string stopped_by(const control::StopCall& call, const std::string& user) {
  // A stop of one experiment alone comes from the command that follows it.
  if (!call.entry) return fmt::format("eha stop of {}", user);
  if (!call.signal) return fmt::format("the command of {}", user);
  if (*call.signal == SIGINT) return fmt::format("Ctrl-C of {}", user);
  const char* name = sigabbrev_np(*call.signal);
  return fmt::format("SIG{} to the command of {}", name != nullptr ? name : std::to_string(*call.signal), user);
}

}  // namespace

Supervisor::Supervisor(const Options& options, control::EventLoop& loop, Notifier& notifier)
    : options_(options),
      notifier_(notifier),
      config_(config::load_service_config(options.config_file)),
      store_(options.state / "queue"),
      fitter_({require_program("eha-worker"), require_program("eha")}),
      checker_({require_program("eha-worker"), require_program("eha")}),
      mailbox_(loop),
      disk_thread_("eha-disk", mailbox_),
      inhibitor_("ehad", {[this] { mailbox_.post([this] { prepare_for_sleep(); }); },
                          [](const std::string& why) { spdlog::warn("{}", undelayed_suspend_text(why)); }}),
      // The snapshot is beside the socket, where ExecStopPost=eha-safe finds it after any end of this process.
      rig_(RigKeeper::load(options.rig_file), options.socket.parent_path() / "safe.json", mailbox_) {
  os::create_folders(runs_folder());
  // Files of a check that was running when the program died.
  std::error_code ignored;
  fs::remove_all(options_.state / "check", ignored);
  os::remove_temporary_files(options_.state / "queue");
  os::remove_temporary_files(runs_folder());
  recover_runs(runs_folder(), [this] { notifier_.extend_timeout(kTimeToRecover); });
  index_ = std::make_unique<RunIndex>(options_.state / "runs.index", runs_folder());
  load_queue();
}

Supervisor::~Supervisor() {
  fitter_.end();
  checker_.end();
  // A run is in progress here only if the program ends by an error; the rig stays open until it is safe.
  if (active_) {
    active_->stop->request();
    active_->stop->request();
  }
}

void Supervisor::load_queue() {
  std::vector<std::string> damaged;
  std::vector<Entry> entries = store_.load(damaged);
  for (const std::string& message : damaged) spdlog::error("{}", message);
  const std::vector<Entry> before = entries;
  settle(entries, runs_folder());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (entries[i].state != before[i].state) store_.save(entries[i]);
  }
  queue_ = Queue(std::move(entries));
  for (const EntryId old : queue_.forget_old(0)) store_.remove(old);
  queue_.hold_waiting("ehad was started anew before it began");
  if (const Entry* fault = queue_.open_fault()) disarmed_because_ = bad_end_of(*fault);
  if (const std::size_t held = queue_.count(EntryState::held); held > 0) {
    spdlog::info("{} experiments are held until their owners arm the rig and release them (eha queue release)", held);
  }
}

void Supervisor::require_lease(const Peer& peer, std::string_view what) const {
  const Lease::Holder* holder = lease_.holder();
  if (!holder || holder->uid == peer.uid || peer.uid == kRoot) return;
  throw PermissionError(fmt::format("{}: the lease is {}'s for another {:.0f} s; wait, or ask {} for eha disarm", what,
                                    holder->user, lease_.remaining(Clock::now()).count(),
                                    holder->uid == kRoot ? holder->user : holder->user + " or root"));
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
      fmt::format("not armed: the sensor's reading jumped in experiment {}, and the rod may stand elsewhere than "
                  "`eha read` shows: mend its holder or cable and hold a ruler to the rod; where both agree: `eha arm "
                  "--ruler LENGTH`; where not: `eha calibrate --sensor-moved` and its Next",
                  slip->id));
}

void Supervisor::close_slips() {
  const std::vector<EntryId> changed = queue_.close_slips();
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
  if (!moved_while_armed_.empty() && !active_ && !rig_.is_armed()) {
    throw DeviceError(fmt::format("not armed: {}; then arm again", std::exchange(moved_while_armed_, {})));
  }
  if (!call.ruler_in && !active_ && !rig_.is_armed()) require_no_slip();
  const bool was_held = lease_.is_held_by(peer.uid);
  if (lease_.holder() && !was_held) {
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
  auto done_arming = [this, peer, was_held, fault, run, grant, answer = std::move(answer)](std::future<void> done) {
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
      if (rig_.moves_machine()) close_slips();
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

void Supervisor::reload(const std::optional<Peer>& peer, Answer answer) {
  if (peer) require_lease(*peer, "not reloaded");
  if (rig_.is_armed() || rig_.is_arming() || active_) {
    throw PermissionError("not reloaded: the rig is armed; eha disarm first");
  }
  notifier_.reloading();
  const auto fail = [this](const std::exception& error) {
    notifier_.ready();
    spdlog::error("not reloaded, the configuration read before stays: {}", error.what());
  };
  try {
    const config::ServiceConfig config = config::load_service_config(options_.config_file);
    const auto read = std::chrono::system_clock::now();
    rig_.reconfigure(RigKeeper::load(options_.rig_file),
                     [this, config, read, fail, answer = std::move(answer)](std::future<void> done) {
                       answer([&]() -> Json {
                         try {
                           done.get();
                         } catch (const std::exception& error) {
                           fail(error);
                           throw;
                         }
                         config_ = config;
                         rig_read_ = read;
                         moved_while_armed_.clear();  // by a new calibration, as a rule
                         notifier_.ready();
                         spdlog::info("configuration reloaded: {} ({}), {}", rig_.config()->name, options_.rig_file,
                                      options_.config_file);
                         return {{"rig", rig_.config()->name}};
                       });
                     });
  } catch (const std::exception& error) {
    fail(error);
    throw;
  }
}

void Supervisor::shut_down() {
  if (active_) active_->stop->request();
  if (!shutting_down_) spdlog::info("stopping{}", active_ ? ": the run that is on is ramped out" : "");
  shutting_down_ = true;
  notifier_.stopping();
}

void Supervisor::poll(Clock::time_point now) {
  if (lease_.has_expired(now)) {
    if (active_) {
      lease_.renew(now);
    } else {
      disarm_rig(fmt::format("the lease of {} has expired", lease_.holder()->user), LeaseFate::released);
    }
  }
  poll_worker();
  poll_guard();
  rig_.poll_unsafe(now);
  poll_rod(now);
  poll_suspend();
  update_inhibitor();
  poll_health(now);
  notifier_.status(status_text());
}

void Supervisor::poll_rod(Clock::time_point now) {
  if (active_ && active_->playing) return;
  if (!rig_.is_arming()) note_circuit(rig_.notices_circuit(), now);  // arming looks at the lines itself
  const std::optional<double> moved_in = rig_.notices_motion();
  if (!moved_in) return;
  const bool is_at_stake = rig_.is_armed() || rig_.is_arming() || active_;
  if (!is_at_stake && now < silent_until_) return;
  silent_until_ = now + kSilence;
  const DisplayUnit unit(rig_.config()->units);
  const std::string why = fmt::format(
      "the rod's reading moved by {:.2g} {} while nothing drove it: look at the rod; if it moves, use the emergency "
      "stop, and look for a welded contactor or a wrong level of [comedi.enable]; if it stands, the sensor or its wire "
      "has slipped (eha calibrate)",
      unit.factor("in") * *moved_in, unit.of("in"));
  if (is_at_stake) moved_while_armed_ = why;
  drive_nothing(why, is_at_stake);
}

void Supervisor::note_circuit(acquisition::CircuitAtRest circuit, Clock::time_point now) {
  using acquisition::CircuitAtRest;
  if (circuit == CircuitAtRest::sound) return;
  const bool is_at_stake = rig_.is_armed() || active_;
  if (active_ && !active_->moved.empty()) return;  // said already
  if (!is_at_stake && (circuit == CircuitAtRest::emergency_stop || now < silent_until_)) return;
  silent_until_ = now + kSilence;
  drive_nothing(std::string(acquisition::sentence_of(circuit)), is_at_stake);
}

void Supervisor::drive_nothing(const std::string& why, bool is_at_stake) {
  spdlog::critical("{}", why);
  if (active_) {
    active_->moved = why;
  } else if (is_at_stake) {
    disarm_rig(why, LeaseFate::kept);
  } else if (queue_.open_fault() == nullptr) {
    disarmed_because_ = why;
  }
}

void Supervisor::poll_guard() {
  if (!rig_.notices_dead_guard()) return;
  spdlog::error("the guard of the rig (eha-safe --guard) has died; nothing is driven without it");
  if (active_) {
    active_->stop->request_ramp_out();
  } else if (rig_.is_armed()) {
    disarm_rig("the guard of the rig has died", LeaseFate::kept);
  }
}

void Supervisor::prepare_for_sleep() {
  if (active_) {
    spdlog::warn("experiment {}: the machine is about to be suspended: ramping out", active_->entry);
    active_->stop->request_ramp_out();
  } else if (rig_.is_armed() || rig_.is_arming()) {
    disarm_rig("the machine is about to be suspended", LeaseFate::kept);
  }
}

void Supervisor::update_inhibitor() noexcept {
  if (active_) {
    inhibitor_.hold();
  } else {
    inhibitor_.release();
  }
}

void Supervisor::poll_suspend() {
  const auto suspended = suspend_.check();
  if (!suspended) return;
  const std::string why = fmt::format("the machine was suspended for {:.1f} s", suspended->count());
  if (active_) {
    // The output held its voltage during the suspend; the position of the rod is unknown.
    spdlog::error("experiment {}: {}; the rig is made safe at once", active_->entry, why);
    active_->stop->request();
    active_->stop->request();
  } else if (rig_.is_armed() || rig_.is_arming()) {
    disarm_rig(why, LeaseFate::kept);
  } else {
    spdlog::warn("{}", why);
  }
}

void Supervisor::poll_health(Clock::time_point now) {
  const play::RunWatch* watch = active_ && active_->playing ? active_->watch.get() : nullptr;
  if (watch != nullptr && watch->phase.load() > play::RunWatch::Phase::playing && !active_->played)
    active_->played = now;
  const std::string fault =
      health_.check(watch, rig_.idle_beats(), now,
                    watch == nullptr && rig_.is_unsafe() ? Health::kUnsafePatience : Health::kLoopPatience);
  if (fault.empty()) {
    notifier_.feed_watchdog();
  } else if (health_was_good_) {
    spdlog::critical("{}{}", fault, notifier_.has_watchdog() ? "; the watchdog is no longer fed" : "");
  }
  health_was_good_ = fault.empty();
}

}  // namespace eha::service
