// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/rig_keeper.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/os/lock_file.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/motion_at_rest.hpp"
#include "daemon/rig/ruler_check.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace eha::service {
namespace {

constexpr std::chrono::milliseconds kIdleRead{20};
constexpr std::chrono::seconds kTryAgain{1};
constexpr std::chrono::seconds kLeftPatience{3};  // a guard that still has the card needs less, unless it refuses
/// Reads skipped after one that failed slowly: a card that does not answer blocks the thread for up to a second.
constexpr int kRestAfterFailure = 49;
constexpr std::chrono::milliseconds kMovesWithin{500};

constexpr std::string_view kNotReloaded =
    "not reloaded: the output of the card in use is not confirmed safe, and another rig file may name another card; "
    "use the emergency stop, and reload once ehad has made the card safe";

template <typename TimePoint>
std::int64_t ns_since_epoch(TimePoint now) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(now.time_since_epoch()).count();
}

}  // namespace

RigKeeper::Config RigKeeper::load(const std::filesystem::path& file) {
  auto config = std::make_shared<config::RigConfig>(config::load_rig(file.string()));
  require_trusted_rig_file(*config);
  return config;
}

RigKeeper::RigKeeper(Config config, std::filesystem::path snapshot, Mailbox& mailbox)
    : config_(std::move(config)),
      snapshot_(std::move(snapshot)),
      thread_(std::make_unique<Background>("eha-rig", mailbox)) {
  if (std::filesystem::exists(snapshot_)) hold_folder();
  try {
    make_left_card_safe(kLeftPatience);
    open(*config_);
  } catch (const Error& error) {
    if (!left_) throw;
    spdlog::critical(
        "{}: THE OUTPUT IS NOT CONFIRMED SAFE since the process before this one: {}; tried again every second",
        left_->device, error.what());
    is_unsafe_ = true;
    is_suspect_ = true;
    rod_.fail(hal::RigStatus::io_error);
  }
  thread_->when_idle(kIdleRead, [this] { read_idle_rig(); });
}

RigKeeper::~RigKeeper() {
  thread_.reset();
  close();
}

bool RigKeeper::moves_machine() const noexcept { return hal::moves_machine(config_->backend); }

std::pair<double, double> RigKeeper::calibration() const {
  const hal::Conversion conversion = hal::conversion_of(config_->backend);
  return {conversion.scale_in_per_V, conversion.offset_in};
}

void RigKeeper::open(const config::RigConfig& config) {
  reads_left_out_ = 0;
  off_since_ = std::chrono::steady_clock::now();  // it may have been made safe just now
  if (config.text != rest_text_) rest_.reset();
  rest_text_ = config.text;
  const ArmingFindings findings = arming_findings(config);
  for (const std::string& sentence : findings.refusals)
    spdlog::error("{}: cannot be armed: {}", config.file_name, sentence);
  for (const std::string& sentence : findings.warnings) spdlog::warn("{}: {}", config.file_name, sentence);
  if (!hal::moves_machine(config.backend)) {
    replica_ = hal::open(config.backend, config.limits.safe_V);
    opened_text_ = config.text;
    rod_.begin(replica_->capabilities());
    return;
  }
  hold_folder();
  card_ = std::make_unique<OwnedRig>(config, snapshot_);
  opened_text_ = config.text;
  const hal::RigCapabilities& card = card_->rig().capabilities();
  rod_.begin(card);
  spdlog::info("{}: open ({}, {}), {}", card.device, card.board, card.driver, rest_text(config));
}

void RigKeeper::hold_folder() {
  if (lock_) return;
  const std::filesystem::path folder = snapshot_.has_parent_path() ? snapshot_.parent_path() : ".";
  // Not the folder itself: all users may open it, and so lock it.
  lock_ =
      os::lock_file(folder / "card.lock",
                    "another process of this user, as a rule another ehad that drives a card and has its socket in "
                    "this folder: eha-safe could not tell the two cards apart; name a socket in a folder of its own "
                    "with --socket DIR/ehad.sock");
}

void RigKeeper::make_left_card_safe(std::chrono::milliseconds patience) {
  if (!left_) {
    if (card_ || !std::filesystem::exists(snapshot_)) return;
    try {
      left_ = hal::safe_action(hal::read_safe_snapshot(snapshot_), snapshot_.string());
    } catch (const Error& error) {
      return spdlog::error("{}: {}", snapshot_.string(), error.what());
    }
  }
  left_->make_safe(patience);
  left_.reset();
  std::error_code ignored;
  std::filesystem::remove(snapshot_, ignored);
}

void RigKeeper::close() noexcept {
  replica_.reset();
  opened_text_.clear();
  if (!card_) return;
  card_->page().beat();
  const bool is_safe = card_->rig().make_safe() == hal::RigStatus::ok;
  try {
    if (is_safe) {
      card_->made_safe();
      std::error_code ignored;
      std::filesystem::remove(snapshot_, ignored);  // it says that somebody must make the card safe
    }
  } catch (const Error& error) {
    spdlog::error("{}", error.what());
  }
  is_unsafe_ = !is_safe;
  if (!is_safe)
    spdlog::critical("{}: THE OUTPUT IS NOT CONFIRMED SAFE; eha-safe tries again", card_->rig().capabilities().device);
  card_.reset();
}

void RigKeeper::close_unsafe() {
  // From now on, not once the thread has tried again: a stop in between would be told that it is safe.
  is_unsafe_ = true;
  is_suspect_ = true;
  ++reopening_;
  thread_->ask([this] { close(); }, [this](std::future<void>) { --reopening_; });
}

void RigKeeper::poll_unsafe(std::chrono::steady_clock::time_point now) {
  if (!is_unsafe_ || reopening_ > 0 || now < next_try_) return;
  next_try_ = now + kTryAgain;
  ++reopening_;
  thread_->ask(
      [this, config = config_] {
        if (left_) {
          const std::string device = left_->device;
          make_left_card_safe({});
          is_unsafe_ = false;
          spdlog::warn("{}: the output is safe now", device);
          return open(*config);
        }
        if (!card_) open(*config);
        if (!card_) return;
        // Opening a card writes the safe state, too; this is the confirmation.
        if (card_->rig().make_safe() != hal::RigStatus::ok) return close();
        is_unsafe_ = false;
        spdlog::warn("{}: the output is safe now", card_->rig().capabilities().device);
      },
      [this](std::future<void> opened) {
        --reopening_;
        try {
          opened.get();
          failed_try_.clear();
        } catch (const Error& error) {
          if (failed_try_ != error.what()) spdlog::error("not confirmed safe: {}", error.what());
          failed_try_ = error.what();
        }
      });
}

void RigKeeper::make_safe() {
  if (is_making_safe_ || !moves_machine()) return;
  next_try_ = {};
  is_making_safe_ = true;
  ++reopening_;  // it may close the card
  thread_->ask(
      [this] {
        if (card_ && card_->rig().make_safe() != hal::RigStatus::ok) {
          spdlog::critical("{}: THE OUTPUT IS NOT CONFIRMED SAFE", card_->rig().capabilities().device);
          close();
        }
      },
      [this](std::future<void>) {
        --reopening_;
        is_making_safe_ = false;
      });
}

RigKeeper::Config RigKeeper::config_of_next_run() const {
  if (!placed_in_) return config_;
  auto config = std::make_shared<config::RigConfig>(*config_);
  hal::begin_at(config->backend, *placed_in_);
  return config;
}

void RigKeeper::rod_is_at(double displacement_in) {
  if (moves_machine()) return;
  placed_in_ = displacement_in;
  rod_.moved_to(displacement_in);
  ++reopening_;
  thread_->ask(
      [this, config = config_of_next_run()] {
        open(*config);
        read_idle_rig();
      },
      [this](std::future<void> opened) {
        --reopening_;
        try {
          opened.get();
        } catch (const Error& error) {
          spdlog::error("{}", error.what());
        }
      });
}

void RigKeeper::read_idle_rig() {
  hal::Rig* rig = card_ ? &card_->rig() : replica_.get();
  if (rig == nullptr) return;
  if (reads_left_out_ > 0) {
    --reads_left_out_;
    return;
  }
  hal::RigReading reading;
  const auto begun = std::chrono::steady_clock::now();
  if (read(*rig, reading) == hal::RigStatus::ok) return;
  // The line of the emergency stop is read by the same call: after a short failure at once again.
  if (std::chrono::steady_clock::now() - begun > acquisition::kSlowFailure) reads_left_out_ = kRestAfterFailure;
}

hal::RigStatus RigKeeper::read(hal::Rig& rig, hal::RigReading& reading) {
  // The time is 0: a run's time begins with the run.
  const hal::RigStatus status = rig.read(0, reading);
  if (status == hal::RigStatus::ok) {
    rod_.add(reading);
    if (card_) {
      note_rest(rig, reading);
      const auto off = std::chrono::steady_clock::now() - off_since_;
      const auto circuit = acquisition::circuit_at_rest(rig, reading, off);
      if (circuit != acquisition::CircuitAtRest::sound) circuit_ = circuit;
    }
    idle_blocks_.add({ns_since_epoch(std::chrono::steady_clock::now()),
                      ns_since_epoch(std::chrono::system_clock::now()), reading.displacement_in});
  } else {
    rod_.fail(status);
  }
  return status;
}

void RigKeeper::note_rest(hal::Rig& rig, const hal::RigReading& reading) {
  const auto now = std::chrono::steady_clock::now();
  const auto moved_in = [&](const hal::RigReading& seen) { return seen.displacement_in - rest_->place_in; };
  const double most_in = rest_ ? most_motion_at_rest(now - rest_->at, rest_->speed_in_per_s) : 0.0;
  if (rest_ && std::abs(moved_in(reading)) > most_in) {
    // Interference in one reading is none.
    hal::RigReading again;
    if (rig.read(0, again) != hal::RigStatus::ok || std::abs(moved_in(again)) <= most_in) return;
    moved_in_ = moved_in(again);
  } else if (rest_ && now - rest_->at < kMovesWithin) {
    return;
  }
  rest_ = {now, reading.displacement_in};
}

std::optional<double> RigKeeper::notices_motion() noexcept {
  const double moved_in = moved_in_.exchange(0.0);
  return moved_in != 0.0 ? std::optional(moved_in) : std::nullopt;
}

acquisition::CircuitAtRest RigKeeper::notices_circuit() noexcept {
  return circuit_.exchange(acquisition::CircuitAtRest::sound);
}

double RigKeeper::read_rod() {
  hal::Rig* rig = card_ ? &card_->rig() : replica_.get();
  hal::RigReading reading;
  if (rig == nullptr) throw DeviceError("the rig is not open; eha arm opens it");
  hal::RigStatus status = read(*rig, reading);
  if (status == hal::RigStatus::timed_out) status = read(*rig, reading);
  if (status != hal::RigStatus::ok) throw DeviceError("cannot read the position of the rod; `eha read` says why");
  return reading.displacement_in;
}

void RigKeeper::read_place(std::function<void(std::future<double>)> then) {
  thread_->ask([this] { return read_rod(); }, std::move(then));
}

RigKeeper::Json RigKeeper::rod(const acquisition::Snapshot& now) const {
  const hal::Conversion conversion = hal::conversion_of(config_->backend);
  hal::RigReading reading;
  reading.displacement_in = now.displacement_in;
  reading.feedback_V = (now.displacement_in - conversion.offset_in) / conversion.scale_in_per_V;
  reading.feedback_code = now.feedback_code;
  reading.digital_inputs = now.digital_inputs;
  reading.feedback_at_rail = (now.flags & acquisition::kFeedbackRail) != 0;
  reading.emergency_stop = (now.flags & acquisition::kEmergencyStop) != 0;
  reading.enable_contact = now.enable_contact;
  return rod_.describe(config_->limits, reading, now.travel_share);
}

void RigKeeper::require_rest_of_before(const config::RigConfig& config) {
  if (!card_ || !rest_) return;
  try {
    require_at_rest(card_->rig(), *rest_, DisplayUnit(config.units));
  } catch (const RodMoved&) {
    rest_.reset();  // said once; it is where it stands now
    throw;
  }
}

void RigKeeper::arm(Done done, std::optional<double> ruler_in) {
  arming_ = true;
  ++reopening_;
  const std::uint64_t number = ++arming_number_;
  thread_->ask(
      [this, config = config_, reopen = is_suspect_, ruler_in] {
        require_protecting_limits(*config);
        if (left_) throw DeviceError("not armed: the output of " + left_->device + " is not confirmed safe");
        const bool needs_card = hal::moves_machine(config->backend) && (reopen || !card_ || card_->is_unguarded());
        // The open rig may have another rig file, after reloads that overtook one another or failed.
        if (needs_card || opened_text_ != config->text) {
          close();
          open(*config);
          require_rest_of_before(*config);
        }
        if (!card_) return;
        if (is_unsafe_) {
          if (card_->rig().make_safe() != hal::RigStatus::ok) {
            throw DeviceError("not armed: the output is not confirmed safe");
          }
          is_unsafe_ = false;
        }
        circuit_ = acquisition::CircuitAtRest::sound;  // what was before is this arming's to judge
        require_plausible_inputs(card_->rig(), *config);
        if (ruler_in) require_place_by_ruler(*ruler_in, read_rod(), DisplayUnit(config->units));
        if (card_->is_unguarded()) throw DeviceError("not armed: the guard of the rig (eha-safe --guard) does not run");
      },
      [this, number, done = std::move(done)](std::future<void> opened) {
        --reopening_;
        const bool is_newest = number == arming_number_;
        std::promise<void> outcome;
        try {
          opened.get();
          is_suspect_ = false;
          if (!arming_ || !is_newest) throw DeviceError("not armed: a stop came first");
          machine_.reset();
          machine_.arm();
          outcome.set_value();
        } catch (...) {
          outcome.set_exception(std::current_exception());
        }
        if (is_newest) arming_ = false;
        done(outcome.get_future());
      });
}

void RigKeeper::reconfigure(Config config, Done done) {
  // Nothing changes for the rig: endless requests must not prevent arming.
  if (reconfiguring_ == 0 && config->text == config_->text) {
    config_ = std::move(config);
    std::promise<void> taken;
    taken.set_value();
    return done(taken.get_future());
  }
  if (is_unsafe_) {
    std::promise<void> refused;
    refused.set_exception(std::make_exception_ptr(DeviceError(std::string(kNotReloaded))));
    return done(refused.get_future());
  }
  ++reconfiguring_;
  ++reopening_;
  thread_->ask(
      [this, config] {
        // Not config_, which an earlier reload may still be about to replace.
        if (config->text == opened_text_) return;
        close();
        if (is_unsafe_) throw DeviceError(std::string(kNotReloaded));
        open(*config);
      },
      [this, config, done = std::move(done)](std::future<void> opened) {
        --reconfiguring_;
        --reopening_;
        std::promise<void> outcome;
        try {
          opened.get();
          config_ = config;
          placed_in_.reset();
          outcome.set_value();
        } catch (...) {
          outcome.set_exception(std::current_exception());
        }
        done(outcome.get_future());
      });
}

GuardState RigKeeper::guard() const noexcept {
  return reopening_ == 0 && card_ && card_->is_unguarded() ? GuardState::died : GuardState::watching;
}

bool RigKeeper::notices_dead_guard() noexcept {
  if (is_suspect_ || guard() == GuardState::watching) return false;
  is_suspect_ = true;
  return true;
}

}  // namespace eha::service
