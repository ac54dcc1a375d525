// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hal/rig.hpp"

namespace eha::hal {

/// A recorded run as a rig: read() plays the readings handed to it, command() keeps what would have been written.
class ReplayRig final : public Rig {
 public:
  /// @param readings   one a tick, not empty
  /// @param period_ns  spacing of the readings, positive [ns]; read(elapsed_ns) plays row elapsed_ns / period_ns, and
  ///                   the last row from its time on
  /// @param recorded   capabilities of the rig that was recorded; `backend` becomes "replay", `virtual_time` true
  /// @param safe_V     what make_safe() writes [V]
  /// @throws DataError  no readings, a period that is not positive, or a command range or step that is not
  ReplayRig(std::vector<RigReading> readings, std::int64_t period_ns, RigCapabilities recorded, double safe_V);

  [[nodiscard]] const RigCapabilities& capabilities() const noexcept override;
  RigStatus read(std::int64_t elapsed_ns, RigReading& reading) noexcept override;
  RigStatus command(double command_V, AppliedCommand& applied) noexcept override;
  RigStatus set_enable(bool on) noexcept override;
  RigStatus make_safe() noexcept override;

  /// What was commanded after each row was read; the last command when there were several. 0 V, code 0 where none was.
  [[nodiscard]] std::span<const AppliedCommand> commands() const noexcept;
  [[nodiscard]] bool enabled() const noexcept;

 private:
  std::vector<RigReading> readings_;
  std::vector<AppliedCommand> commands_;
  std::int64_t period_ns_;
  RigCapabilities capabilities_;
  double safe_V_;
  std::size_t row_ = 0;
  bool enabled_ = false;
};

}  // namespace eha::hal
