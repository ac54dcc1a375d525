// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

#include "hal/rig.hpp"

namespace eha::test {

/// Passes every call on to another rig; what a test changes of it is in a derived class.
class PassingRig : public hal::Rig {
 public:
  explicit PassingRig(hal::Rig& rig) : rig_(rig) {}
  [[nodiscard]] const hal::RigCapabilities& capabilities() const noexcept override { return rig_.capabilities(); }
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    return rig_.read(elapsed_ns, reading);
  }
  hal::RigStatus command(double command_V, hal::AppliedCommand& applied) noexcept override {
    return rig_.command(command_V, applied);
  }
  hal::RigStatus set_enable(bool on) noexcept override { return rig_.set_enable(on); }
  hal::RigStatus make_safe() noexcept override { return rig_.make_safe(); }

 private:
  hal::Rig& rig_;
};

}  // namespace eha::test
