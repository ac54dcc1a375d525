// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "hal/rig.hpp"

namespace eha::acquisition {

/// Looks at the place where the rod truly is.
class TrueRod final : public hal::Rig {
 public:
  explicit TrueRod(hal::Rig& rig) : rig_(rig) {}
  [[nodiscard]] const hal::RigCapabilities& capabilities() const noexcept override { return rig_.capabilities(); }
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const hal::RigStatus status = rig_.read(elapsed_ns, reading);
    place_in = reading.displacement_in;
    return status;
  }
  hal::RigStatus command(double command_V, hal::AppliedCommand& applied) noexcept override {
    return rig_.command(command_V, applied);
  }
  hal::RigStatus set_enable(bool on) noexcept override { return rig_.set_enable(on); }
  hal::RigStatus make_safe() noexcept override { return rig_.make_safe(); }

  double place_in = 0.0;

 private:
  hal::Rig& rig_;
};

}  // namespace eha::acquisition
