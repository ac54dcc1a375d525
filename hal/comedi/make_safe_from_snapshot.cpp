// SPDX-License-Identifier: GPL-3.0-or-later
#include <comedilib.h>

#include <exception>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "hal/comedi/comedi_device.hpp"
#include "hal/comedi/safe_snapshot.hpp"

namespace eha::hal {
namespace {

constexpr std::chrono::milliseconds kPause{10};

/// One of the two steps, tried until it succeeds.
struct Step {
  const char* failing;  ///< message until it succeeds
  RigStatus status = RigStatus::io_error;
  std::string cause = {};

  void take(RigStatus result) {
    status = result;
    if (status != RigStatus::ok) cause = last_comedi_error();
  }
};

RigStatus switch_off(comedi_t* device, const SafeSnapshot::Line& line) {
  const RigStatus written = write_line(device, line.subdevice, line.channel, line.off_level);
  if (written != RigStatus::ok || !line.is_bidirectional) return written;
  return comedi_dio_config(device, line.subdevice, line.channel, COMEDI_OUTPUT) < 0 ? last_comedi_status()
                                                                                    : RigStatus::ok;
}

}  // namespace

SafeCard::SafeCard(SafeSnapshot snapshot) : snapshot_(std::move(snapshot)) {}
SafeCard::~SafeCard() = default;

ComediDevice& SafeCard::device() {
  if (device_) return *device_;
  auto opened = std::make_unique<ComediDevice>(snapshot_.device);
  const char* board = comedi_get_board_name(opened->get());
  if (board == nullptr || board != snapshot_.board) {
    throw ConfigError(snapshot_.device + ": expected the board \"" + snapshot_.board + "\", found \"" +
                      (board != nullptr ? board : "") + "\"; nothing was written: make the rig safe by hand");
  }
  device_ = std::move(opened);
  return *device_;
}

bool SafeCard::keep_open() noexcept {
  try {
    (void)device();
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

bool SafeCard::switch_off() noexcept {
  if (!snapshot_.enable) return false;
  try {
    const RigStatus status = hal::switch_off(device().get(), *snapshot_.enable);
    if (status == RigStatus::removed) device_.reset();
    return status == RigStatus::ok;
  } catch (const std::exception&) {
    // The device cannot be opened: the guard tries again.
    return false;
  }
}

void SafeCard::make_safe(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  const auto is_over = [&] { return std::chrono::steady_clock::now() >= deadline; };
  Step output{.failing = "the output is not at its safe voltage"};
  Step enable{.failing = "the hydraulics are not switched off"};
  if (!snapshot_.enable) enable.status = RigStatus::ok;
  const unsigned chanspec = CR_PACK(snapshot_.channel, snapshot_.range, snapshot_.reference);
  for (;; std::this_thread::sleep_for(kPause)) {
    comedi_t* card = nullptr;
    try {
      card = device().get();
    } catch (const ConfigError& error) {
      throw DeviceError(error.what());
    } catch (const Error&) {
      // Retries after any cause: the program that wrote the snapshot had the device open, and a node that reappears has
      // other rights until udev has set them.
      if (is_over()) throw;
      continue;
    }
    // The enable line first: a write to the output may take a second to time out.
    if (enable.status != RigStatus::ok) enable.take(hal::switch_off(card, *snapshot_.enable));
    if (output.status != RigStatus::ok) {
      output.take(write_code(card, snapshot_.subdevice, chanspec, snapshot_.safe_code));
    }
    if (output.status == RigStatus::ok && enable.status == RigStatus::ok) return;
    // A removed card does not return to this descriptor.
    if (output.status == RigStatus::removed || enable.status == RigStatus::removed) device_.reset();
    if (is_over()) break;
  }
  std::string message = snapshot_.device + ": NOT SAFE";
  for (const Step& step : {enable, output}) {
    if (step.status != RigStatus::ok) message += std::string(": ") + step.failing + " (" + step.cause + ")";
  }
  throw DeviceError(message + ": make the rig safe by hand");
}

}  // namespace eha::hal
