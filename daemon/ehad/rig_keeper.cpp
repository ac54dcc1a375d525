// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/rig_keeper.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <utility>

#include "core/error.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backend.hpp"

namespace eha::service {

RigKeeper::Config RigKeeper::load(const std::filesystem::path& file) {
  auto config = std::make_shared<config::RigConfig>(config::load_rig(file.string()));
  require_trusted_rig_file(*config);
  return config;
}

RigKeeper::RigKeeper(Config config, std::filesystem::path snapshot, Mailbox& mailbox)
    : config_(std::move(config)),
      snapshot_(std::move(snapshot)),
      thread_(std::make_unique<Background>("eha-rig", mailbox)) {
  open(*config_);
}

RigKeeper::~RigKeeper() {
  thread_.reset();
  close();
}

bool RigKeeper::moves_machine() const noexcept { return hal::moves_machine(config_->backend); }

void RigKeeper::open(const config::RigConfig& config) {
  if (!hal::moves_machine(config.backend)) return;
  card_ = std::make_unique<OwnedRig>(config, snapshot_);
  const hal::RigCapabilities& card = card_->rig().capabilities();
  spdlog::info("{}: open ({}, {}), at {} V with the hydraulics off", card.device, card.board, card.driver,
               config.limits.safe_V);
  const ArmingFindings findings = arming_findings(config);
  for (const std::string& sentence : findings.refusals)
    spdlog::error("{}: cannot be armed: {}", config.file_name, sentence);
  for (const std::string& sentence : findings.warnings) spdlog::warn("{}: {}", config.file_name, sentence);
}

void RigKeeper::close() noexcept {
  if (!card_) return;
  const bool is_safe = card_->rig().make_safe() == hal::RigStatus::ok;
  try {
    if (is_safe) card_->made_safe();
  } catch (const Error& error) {
    spdlog::error("{}", error.what());
  }
  if (!is_safe)
    spdlog::critical("{}: THE OUTPUT IS NOT CONFIRMED SAFE; eha-safe tries again", card_->rig().capabilities().device);
  card_.reset();
}

void RigKeeper::arm(Done done) {
  arming_ = true;
  ++reopening_;
  thread_->ask(
      [this, config = config_, reopen = is_suspect_] {
        require_protecting_limits(*config);
        if (hal::moves_machine(config->backend) && (reopen || !card_)) {
          close();
          open(*config);
        }
        if (card_) require_plausible_inputs(card_->rig(), *config);
      },
      [this, done = std::move(done)](std::future<void> opened) {
        --reopening_;
        std::promise<void> outcome;
        try {
          opened.get();
          is_suspect_ = false;
          if (!arming_) throw DeviceError("not armed: a stop came first");
          machine_.reset();
          machine_.arm();
          outcome.set_value();
        } catch (...) {
          outcome.set_exception(std::current_exception());
        }
        arming_ = false;
        done(outcome.get_future());
      });
}

void RigKeeper::reconfigure(Config config, Done done) {
  const bool is_new = config->text != config_->text;
  ++reconfiguring_;
  ++reopening_;
  thread_->ask(
      [this, config, is_new] {
        if (!is_new) return;
        close();
        open(*config);
      },
      [this, config, done = std::move(done)](std::future<void> opened) {
        --reconfiguring_;
        --reopening_;
        std::promise<void> outcome;
        try {
          opened.get();
          config_ = config;
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
