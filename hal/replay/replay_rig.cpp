// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/replay/replay_rig.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"

namespace eha::hal {

ReplayRig::ReplayRig(std::vector<RigReading> readings, std::int64_t period_ns, RigCapabilities recorded, double safe_V)
    : readings_(std::move(readings)),
      commands_(readings_.size()),
      period_ns_(period_ns),
      capabilities_(std::move(recorded)),
      safe_V_(safe_V) {
  if (readings_.empty()) throw DataError("the run to be replayed has no ticks");
  if (period_ns_ <= 0)
    throw DataError("the run to be replayed has a sample period of " + std::to_string(period_ns_) + " ns");
  if (!(capabilities_.command_lsb_V > 0.0 && capabilities_.command_min_V < capabilities_.command_max_V)) {
    throw DataError("the run to be replayed does not say which range its command had");
  }
  capabilities_.backend = "replay";
  capabilities_.virtual_time = true;
}

const RigCapabilities& ReplayRig::capabilities() const noexcept { return capabilities_; }

RigStatus ReplayRig::read(std::int64_t elapsed_ns, RigReading& reading) noexcept {
  const std::int64_t last = static_cast<std::int64_t>(readings_.size()) - 1;
  row_ = static_cast<std::size_t>(std::clamp<std::int64_t>(elapsed_ns / period_ns_, 0, last));
  reading = readings_[row_];
  return RigStatus::ok;
}

RigStatus ReplayRig::command(double command_V, AppliedCommand& applied) noexcept {
  if (!std::isfinite(command_V)) return RigStatus::not_finite;
  const double volts = std::clamp(command_V, capabilities_.command_min_V, capabilities_.command_max_V);
  const double lsb_V = capabilities_.command_lsb_V;
  applied.code = static_cast<std::uint32_t>(std::floor((volts - capabilities_.command_min_V) / lsb_V + 0.5));
  applied.applied_V = capabilities_.command_min_V + lsb_V * applied.code;
  commands_[row_] = applied;
  return RigStatus::ok;
}

RigStatus ReplayRig::set_enable(bool on) noexcept {
  enabled_ = on;
  return RigStatus::ok;
}

RigStatus ReplayRig::make_safe() noexcept {
  AppliedCommand applied;
  const RigStatus status = command(safe_V_, applied);
  enabled_ = false;
  return status;
}

std::span<const AppliedCommand> ReplayRig::commands() const noexcept { return commands_; }

bool ReplayRig::enabled() const noexcept { return enabled_; }

}  // namespace eha::hal
