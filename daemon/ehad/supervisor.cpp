// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/supervisor.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/program_path.hpp"
#include "daemon/ehad/recovery.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backend.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::seconds kTimeToRecover{600};

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
      programs_{require_program("eha-worker"), require_program("eha")},
      store_(options.state / "queue"),
      mailbox_(loop),
      clerk_("eha-clerk", mailbox_),
      player_(std::make_unique<Background>("eha-player", mailbox_)) {
  load_configuration();
  os::create_folders(runs_folder());
  open_rig();
  recover_runs(runs_folder(), [this] { notifier_.extend_timeout(kTimeToRecover); });
  load_queue();
}

Supervisor::~Supervisor() {
  fitting_.reset();
  // Only when the program ends by an error there is still a run; the rig stays open until it is safe.
  if (active_) {
    active_->stop->request();
    active_->stop->request();
  }
  player_.reset();
  close_rig();
}

void Supervisor::load_configuration() {
  const config::ServiceConfig config = config::load_service_config(options_.config_file);
  auto rig = std::make_shared<config::RigConfig>(config::load_rig(options_.rig_file));
  require_trusted_rig_file(*rig);
  config_ = config;
  rig_config_ = std::move(rig);
}

void Supervisor::open_rig() {
  if (hal::moves_machine(rig_config_->backend)) {
    // Beside the socket, where ExecStopPost=eha-safe finds it after whatever end this process comes to.
    card_ = std::make_unique<OwnedRig>(*rig_config_, options_.socket.parent_path() / "safe.json");
    const hal::RigCapabilities& card = card_->rig().capabilities();
    spdlog::info("{}: open ({}, {}), at {} V with the hydraulics off", card.device, card.board, card.driver,
                 rig_config_->limits.safe_V);
  }
  card_is_suspect_ = false;
}

void Supervisor::close_rig() {
  if (!card_) return;
  const bool is_safe = card_->rig().make_safe() == hal::RigStatus::ok;
  try {
    if (is_safe) card_->made_safe();
  } catch (const Error& error) {
    spdlog::error("{}", error.what());
  }
  if (!is_safe) spdlog::critical("{}: THE OUTPUT IS NOT CONFIRMED SAFE; eha-safe tries again", rig_config_->name);
  card_.reset();
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
  if (const std::size_t waiting = queue_.count(EntryState::waiting); waiting > 0) {
    spdlog::info("{} experiments wait until their owners arm the rig", waiting);
  }
}

Json Supervisor::arm(const Peer& peer) {
  if (shutting_down_) throw DeviceError("ehad is stopping; try again once it has restarted");
  const Lease::Holder* holder = lease_.holder();
  if (holder && holder->uid != peer.uid) {
    throw PermissionError(fmt::format("the rig is armed by {} for another {:.0f} s; wait, or ask for eha disarm",
                                      holder->user, lease_.remaining(Clock::now()).count()));
  }
  lease_.grant({peer.uid, peer.user}, Clock::now());
  if (!active_ && machine_.state() != acquisition::State::armed) {
    try {
      if (hal::moves_machine(rig_config_->backend) && (!card_ || card_is_suspect_)) {
        close_rig();
        open_rig();
      }
    } catch (...) {
      lease_.release();
      throw;
    }
    machine_.reset();
    machine_.arm();
    spdlog::info("armed by {} (uid {}, pid {}) for {} min", peer.user, peer.uid, peer.pid, Lease::kDuration.count());
    disarmed_because_.clear();
    start_next();
  }
  return {{"state", acquisition::to_text(state())}, {"lease_remaining_s", lease_.remaining(Clock::now()).count()}};
}

Json Supervisor::disarm(const Peer& peer) {
  const Lease::Holder* holder = lease_.holder();
  if (holder && holder->uid != peer.uid) {
    throw PermissionError(
        fmt::format("the rig is armed by {}, who alone may disarm it; eha stop is for everyone", holder->user));
  }
  if (active_) throw UsageError("a run is on; eha stop ramps it out and disarms the rig");
  if (holder) require_arming(fmt::format("disarmed by {}", peer.user));
  return {{"state", acquisition::to_text(state())}};
}

Json Supervisor::stop(const Peer& peer, std::optional<EntryId> only) {
  if (only && (!active_ || active_->entry != *only)) return {{"stopped", "nothing"}};
  if (active_) {
    active_->stop->request();
    const bool is_first = active_->stop->count() == 1;
    spdlog::warn("experiment {}: stop by {} (uid {}, pid {}): {}", active_->entry, peer.user, peer.uid, peer.pid,
                 is_first ? "ramping out" : "safe at once");
    return {{"stopped", is_first ? "ramping_out" : "safe_at_once"}, {"entry", active_->entry}};
  }
  if (!lease_.holder()) return {{"stopped", "nothing"}};
  require_arming(fmt::format("stopped by {}", peer.user));
  return {{"stopped", "disarmed"}};
}

void Supervisor::require_arming(const std::string& why) {
  disarmed_because_ = why;
  lease_.release();
  machine_.disarm();
  const std::size_t waiting = queue_.count(EntryState::waiting);
  spdlog::info("disarmed: {}{}", why, waiting > 0 ? fmt::format("; {} experiments wait", waiting) : "");
}

Json Supervisor::reload() {
  if (lease_.holder() || active_) {
    throw PermissionError("not reloaded: the rig is armed; eha disarm first");
  }
  notifier_.reloading();
  const auto old_rig = rig_config_;
  const config::ServiceConfig old_config = config_;
  try {
    load_configuration();
    if (rig_config_->text != old_rig->text) {
      close_rig();
      open_rig();
    }
  } catch (const std::exception& error) {
    config_ = old_config;
    rig_config_ = old_rig;
    // The card may have been let go for nothing; arming opens it again.
    notifier_.ready();
    spdlog::error("not reloaded, what was read before stays: {}", error.what());
    throw;
  }
  notifier_.ready();
  spdlog::info("configuration reloaded: {} ({}), {}", rig_config_->name, options_.rig_file, options_.config_file);
  return {{"rig", rig_config_->name}};
}

void Supervisor::shut_down() {
  if (active_) active_->stop->request();
  if (!shutting_down_) spdlog::info("stopping{}", active_ ? ": the run that is on is ramped out" : "");
  shutting_down_ = true;
  notifier_.stopping();
}

void Supervisor::turn(Clock::time_point now) {
  if (lease_.has_expired(now)) {
    if (active_) {
      lease_.renew(now);
    } else {
      require_arming(fmt::format("the lease of {} has expired", lease_.holder()->user));
    }
  }
  look_after_worker();
  look_after_guard();
  const play::RunWatch* watch = active_ && active_->playing ? active_->watch.get() : nullptr;
  const std::string fault = health_.check(watch, player_->beats(), now);
  if (fault.empty()) {
    notifier_.feed_watchdog();
  } else if (health_was_good_) {
    spdlog::critical("{}{}", fault, notifier_.has_watchdog() ? "; the watchdog is not fed any more" : "");
  }
  health_was_good_ = fault.empty();
  notifier_.status(status_text());
}

void Supervisor::look_after_guard() {
  // Suspect already: said once, and the card is opened anew, with a new guard, before it is armed again.
  if (!card_ || card_is_suspect_ || !card_->is_unguarded()) return;
  card_is_suspect_ = true;
  spdlog::error("the guard of the rig (eha-safe --guard) has died; nothing is driven without it");
  if (active_) {
    active_->stop->request_ramp_out();
  } else if (lease_.holder()) {
    require_arming("the guard of the rig has died");
  }
}

}  // namespace eha::service
