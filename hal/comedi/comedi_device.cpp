// SPDX-License-Identifier: GPL-3.0-or-later
#include "hal/comedi/comedi_device.hpp"

#include <fcntl.h>

#include <cerrno>

#include "core/error.hpp"
#include "hal/comedi/comedi_rig.hpp"

namespace eha::hal {
namespace {

SubdeviceKind kind_of(int type) {
  switch (type) {
    case COMEDI_SUBD_AI:
      return SubdeviceKind::analog_input;
    case COMEDI_SUBD_AO:
      return SubdeviceKind::analog_output;
    case COMEDI_SUBD_DI:
      return SubdeviceKind::digital_input;
    case COMEDI_SUBD_DO:
      return SubdeviceKind::digital_output;
    case COMEDI_SUBD_DIO:
      return SubdeviceKind::digital_io;
    default:
      return SubdeviceKind::other;
  }
}

SubdeviceDescription describe_subdevice(comedi_t* device, unsigned index) {
  SubdeviceDescription description;
  description.kind = kind_of(comedi_get_subdevice_type(device, index));
  const int channels = comedi_get_n_channels(device, index);
  description.channels = channels > 0 ? static_cast<unsigned>(channels) : 0;
  if (description.kind != SubdeviceKind::analog_input && description.kind != SubdeviceKind::analog_output) {
    return description;
  }
  const int flags = comedi_get_subdevice_flags(device, index);
  if (flags & SDF_GROUND) description.references.push_back(AnalogReference::ground);
  if (flags & SDF_COMMON) description.references.push_back(AnalogReference::common);
  if (flags & SDF_DIFF) description.references.push_back(AnalogReference::diff);
  if (flags & SDF_OTHER) description.references.push_back(AnalogReference::other);
  // If each channel has its own ranges, those of channel 0 say nothing about the others: lists none.
  if (comedi_range_is_chan_specific(device, index) > 0 || comedi_maxdata_is_chan_specific(device, index) > 0) {
    return description;
  }
  description.last_code = comedi_get_maxdata(device, index, 0);
  const int ranges = comedi_get_n_ranges(device, index, 0);
  for (int i = 0; i < ranges; ++i) {
    const comedi_range* range = comedi_get_range(device, index, 0, static_cast<unsigned>(i));
    if (range && range->unit == UNIT_volt) {
      description.ranges.push_back({static_cast<unsigned>(i), range->min, range->max});
    }
  }
  return description;
}

RigStatus one_instruction(comedi_t* device, comedi_insn& instruction) noexcept {
  return comedi_do_insn(device, &instruction) < 0 ? last_comedi_status() : RigStatus::ok;
}

}  // namespace

ComediDevice::ComediDevice(const std::string& path) {
  // Process-wide: the library prints nothing, and codes 0 and full scale are voltages like any other, not NaN.
  comedi_loglevel(0);
  comedi_set_global_oor_behavior(COMEDI_OOR_NUMBER);
  handle_ = comedi_open(path.c_str());
  if (!handle_) {
    const int cause = comedi_errno();
    const std::string what = path + ": cannot open the card: " + comedi_strerror(cause);
    if (cause == EACCES || cause == EPERM) {
      throw PermissionError(what + "; join the group that owns it (Debian: iocard) and log in again");
    }
    if (cause == ENOENT) throw DeviceError(what + "; is the driver's module loaded, and is this the right device?");
    throw DeviceError(what + "; is a card configured there?");
  }
  const int descriptor = comedi_fileno(handle_);
  const int flags = fcntl(descriptor, F_GETFD);
  if (flags < 0 || fcntl(descriptor, F_SETFD, flags | FD_CLOEXEC) != 0) {
    comedi_close(handle_);
    throw DeviceError(path + ": cannot keep the card from child processes");
  }
}

ComediDevice::~ComediDevice() { comedi_close(handle_); }

CardDescription ComediDevice::describe() const {
  CardDescription card;
  const char* board = comedi_get_board_name(handle_);
  const char* driver = comedi_get_driver_name(handle_);
  card.board = board ? board : "";
  card.driver = driver ? driver : "";
  const int subdevices = comedi_get_n_subdevices(handle_);
  for (int i = 0; i < subdevices; ++i) card.subdevices.push_back(describe_subdevice(handle_, static_cast<unsigned>(i)));
  return card;
}

RigStatus last_comedi_status() noexcept {
  switch (comedi_errno()) {
    case ETIME:
    case ETIMEDOUT:
      return RigStatus::timed_out;
    case EBUSY:
      return RigStatus::busy;
    case EACCES:
      return RigStatus::locked;
    case ENODEV:
    case ENXIO:
      return RigStatus::removed;
    default:
      return RigStatus::io_error;
  }
}

std::string last_comedi_error() { return comedi_strerror(comedi_errno()); }

RigStatus write_line(comedi_t* device, unsigned subdevice, unsigned channel, unsigned level) noexcept {
  lsampl_t bits[2] = {1U << channel, level << channel};
  comedi_insn instruction{.insn = INSN_BITS, .n = 2, .data = bits, .subdev = subdevice, .chanspec = 0, .unused = {}};
  return one_instruction(device, instruction);
}

RigStatus write_code(comedi_t* device, unsigned subdevice, unsigned chanspec, lsampl_t code) noexcept {
  comedi_insn instruction{
      .insn = INSN_WRITE, .n = 1, .data = &code, .subdev = subdevice, .chanspec = chanspec, .unused = {}};
  return one_instruction(device, instruction);
}

CardDescription describe_card(const std::string& device) { return ComediDevice(device).describe(); }

}  // namespace eha::hal
