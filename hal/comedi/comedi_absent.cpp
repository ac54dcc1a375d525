// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for the comedi backend in a build without libcomedi.
#include "core/error.hpp"
#include "hal/comedi/comedi_rig.hpp"
#include "hal/comedi/safe_snapshot.hpp"

namespace eha::hal {
namespace {

[[noreturn]] void refuse(const std::string& device) {
  throw DeviceError(device + ": this build cannot drive a card; install libcomedi-dev and build again");
}

}  // namespace

std::unique_ptr<Rig> open_rig(const ComediOptions& options, double) { refuse(options.device); }

CardDescription describe_card(const std::string& device) { refuse(device); }

bool switch_off_from_snapshot(const SafeSnapshot&) noexcept { return false; }

void make_safe_from_snapshot(const SafeSnapshot& snapshot, std::chrono::milliseconds) { refuse(snapshot.device); }

}  // namespace eha::hal
