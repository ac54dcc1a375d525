// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for the comedi backend in a build without libcomedi.
#include <utility>

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

class ComediDevice {};

SafeCard::SafeCard(SafeSnapshot snapshot) : snapshot_(std::move(snapshot)) {}
SafeCard::~SafeCard() = default;
bool SafeCard::keep_open() noexcept { return false; }
bool SafeCard::switch_off() noexcept { return false; }
void SafeCard::make_safe(std::chrono::milliseconds) { refuse(snapshot_.device); }

}  // namespace eha::hal
