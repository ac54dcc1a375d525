// SPDX-License-Identifier: GPL-3.0-or-later
// Start, shutdown, reloading, and what is looked at several times a second.
#include "daemon/ehad/supervisor.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "daemon/ehad/left_card.hpp"
#include "daemon/ehad/recovery.hpp"
#include "hal/backends/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kTimeToRecover{600};
constexpr std::chrono::seconds kSilence{10};   ///< after a message on motion at rest
constexpr double kFartherThanByHand_in = 0.1;  ///< between two readings at rest

fs::path require_program(const char* name) {
  fs::path program = find_program(name);
  if (program.empty()) {
    throw ConfigError(fmt::format("{}: not found beside ehad; install the whole package", name));
  }
  return program;
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
      preparing_thread_("eha-prepare", mailbox_),
      inhibitor_("ehad", {[this] { mailbox_.post([this] { prepare_for_sleep(); }); },
                          [](const std::string& why) { spdlog::warn("{}", undelayed_suspend_text(why)); }}),
      // The snapshot is beside the socket, where ExecStopPost=eha-safe finds it after any end of this process.
      rig_(RigKeeper::load(options.rig_file), snapshot_beside(options.socket), mailbox_) {
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
  const fs::path page_folder = snapshot_beside(options_.socket).parent_path();
  const bool keeps_last_rows = os::is_in_memory(page_folder);
  if (!keeps_last_rows && hal::moves_machine(rig_.config()->backend)) {
    spdlog::warn(
        "{} is on a disk: the last rows of a run do not survive a kill of service and guard at once; after a kill in a "
        "run arming asks for a ruler",
        page_folder.empty() ? "the present folder" : page_folder.string());
  }
  settle(entries, runs_folder(), keeps_last_rows);
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
    const auto calibration = rig_.calibration();
    rig_.reconfigure(RigKeeper::load(options_.rig_file),
                     [this, config, read, calibration, fail, answer = std::move(answer)](std::future<void> done) {
                       answer([&]() -> Json {
                         try {
                           done.get();
                         } catch (const std::exception& error) {
                           fail(error);
                           throw;
                         }
                         config_ = config;
                         rig_read_ = read;
                         if (!is_same_place(calibration, rig_.calibration())) {
                           moved_at_rest_.clear();
                           if (queue_.open_slip(calibration) != nullptr) rig_.forget_slips();
                         }
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
  const DisplayUnit unit(rig_.config()->units);
  const std::string why = fmt::format(
      "the rod's reading moved by {:.2g} {} while nothing drove it: look at the rod; if it moves, use the emergency "
      "stop, and look for a welded contactor or a wrong level of [comedi.enable]; if it stands, the sensor or its wire "
      "has slipped (eha calibrate)",
      unit.factor("in") * *moved_in, unit.of("in"));
  // A hand moves no rod so far between two readings, and a slip of the sensor is as bad while nothing is armed.
  if (is_at_stake || std::abs(*moved_in) > kFartherThanByHand_in) moved_at_rest_ = why;
  if (!is_at_stake && now < silent_until_) return;
  silent_until_ = now + kSilence;
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
