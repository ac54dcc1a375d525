// SPDX-License-Identifier: GPL-3.0-or-later
#include <comedilib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <exception>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "hal/comedi/comedi_device.hpp"
#include "hal/comedi/safe_snapshot.hpp"

namespace eha::hal {
namespace {

constexpr std::chrono::milliseconds kPause{10};

/// One of the two steps, tried until it succeeds.
struct Step {
  const char* failing;  ///< message as long as it has not succeeded
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

/// The card, once it opens: a system short of memory or descriptors refuses for a while.
ComediDevice opened(const std::string& path, std::chrono::steady_clock::time_point deadline) {
  for (;;) {
    try {
      return ComediDevice(path);
    } catch (const DeviceError&) {
      constexpr std::array kPassing{EBUSY, ENOMEM, ENFILE, EMFILE, EAGAIN, EINTR};
      const bool may_pass = std::find(kPassing.begin(), kPassing.end(), comedi_errno()) != kPassing.end();
      if (!may_pass || std::chrono::steady_clock::now() >= deadline) throw;
    }
    std::this_thread::sleep_for(kPause);
  }
}

bool is_the_board(const ComediDevice& device, const SafeSnapshot& snapshot) {
  const char* board = comedi_get_board_name(device.get());
  return board != nullptr && board == snapshot.board;
}

}  // namespace

bool switch_off_from_snapshot(const SafeSnapshot& snapshot) noexcept {
  if (!snapshot.enable) return false;
  try {
    const ComediDevice device(snapshot.device);
    return is_the_board(device, snapshot) && switch_off(device.get(), *snapshot.enable) == RigStatus::ok;
  } catch (const std::exception&) {
    // It does not open: the guard tries again.
    return false;
  }
}

void make_safe_from_snapshot(const SafeSnapshot& snapshot, std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  const ComediDevice device = opened(snapshot.device, deadline);
  if (!is_the_board(device, snapshot)) {
    const char* board = comedi_get_board_name(device.get());
    throw DeviceError(snapshot.device + ": expected the board \"" + snapshot.board + "\", found \"" +
                      (board ? board : "") + "\"; nothing was written: make the rig safe by hand");
  }
  Step output{.failing = "the output is not at its safe voltage"};
  Step enable{.failing = "the hydraulics are not switched off"};
  if (!snapshot.enable) enable.status = RigStatus::ok;
  const unsigned chanspec = CR_PACK(snapshot.channel, snapshot.range, snapshot.reference);
  for (;;) {
    // The enable line first: a write to the output may take a second to time out.
    if (enable.status != RigStatus::ok) enable.take(switch_off(device.get(), *snapshot.enable));
    if (output.status != RigStatus::ok) {
      output.take(write_code(device.get(), snapshot.subdevice, chanspec, snapshot.safe_code));
    }
    if (output.status == RigStatus::ok && enable.status == RigStatus::ok) return;
    // A card that is gone does not come back to this descriptor.
    if (output.status == RigStatus::removed || enable.status == RigStatus::removed) break;
    if (std::chrono::steady_clock::now() >= deadline) break;
    std::this_thread::sleep_for(kPause);
  }
  std::string message = snapshot.device + ": NOT SAFE";
  for (const Step& step : {enable, output}) {
    if (step.status != RigStatus::ok) message += std::string(": ") + step.failing + " (" + step.cause + ")";
  }
  throw DeviceError(message + ": make the rig safe by hand");
}

}  // namespace eha::hal
