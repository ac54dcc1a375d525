// SPDX-License-Identifier: GPL-3.0-or-later
#include "stand_in_comedi.hpp"

#include <comedilib.h>
#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>

struct comedi_t_struct {
  int descriptor = -1;
  int removals = 0;  ///< of the card when this was opened
};

namespace eha::hal::testing {
namespace {

// The subdevices of the card, in its driver's order.
constexpr std::array kTypes{COMEDI_SUBD_AI, COMEDI_SUBD_AO, COMEDI_SUBD_DI, COMEDI_SUBD_DO};
constexpr lsampl_t kLastCode = 65535;

int last_error = 0;

int fail(int error) {
  last_error = error;
  return -1;
}

int digital(lsampl_t mask, lsampl_t levels) {
  StandInCard& card = stand_in_card();
  if (mask & 1U) {
    card.writes.push_back(levels & 1U ? StandInCard::Write::enable_on : StandInCard::Write::enable_off);
    if (card.enable_refused) return fail(EIO);
  } else {
    card.writes.push_back(StandInCard::Write::heartbeat);
  }
  card.digital_outputs = (card.digital_outputs & ~mask) | (levels & mask);
  return 1;
}

int perform(const comedi_insn& instruction) {
  StandInCard& card = stand_in_card();
  switch (instruction.subdev) {
    case 0:
      if (instruction.insn == INSN_READ && instruction.n > 0) instruction.data[0] = card.feedback_code;
      return 1;
    case 1:
      card.writes.push_back(StandInCard::Write::output);
      if (card.output_times_out) return fail(ETIME);
      card.output_code = instruction.data[0];
      return 1;
    case 2:
      instruction.data[1] = 1;  // the emergency-stop circuit is closed
      return 1;
    default:
      return digital(instruction.data[0], instruction.data[1]);
  }
}

}  // namespace

StandInCard& stand_in_card() {
  static StandInCard card;
  return card;
}

}  // namespace eha::hal::testing

using eha::hal::testing::kLastCode;
using eha::hal::testing::kTypes;

extern "C" {

comedi_t* comedi_open(const char*) {
  auto& card = eha::hal::testing::stand_in_card();
  if (card.open_error != 0 && card.open_failures > 0) {
    --card.open_failures;
    eha::hal::testing::last_error = card.open_error;
    return nullptr;
  }
  return new comedi_t_struct{open("/dev/null", O_RDWR), card.removals};
}
int comedi_close(comedi_t* device) {
  const int result = close(device->descriptor);
  delete device;
  return result;
}
int comedi_fileno(comedi_t* device) { return device->descriptor; }
int comedi_loglevel(int) { return 0; }
int comedi_errno() { return eha::hal::testing::last_error; }
const char* comedi_strerror(int) { return "refused by the stand-in"; }
comedi_oor_behavior comedi_set_global_oor_behavior(comedi_oor_behavior) { return COMEDI_OOR_NUMBER; }
const char* comedi_get_board_name(comedi_t*) { return "pci1716"; }
const char* comedi_get_driver_name(comedi_t*) { return "adv_pci1710"; }
int comedi_get_n_subdevices(comedi_t*) { return static_cast<int>(kTypes.size()); }
int comedi_get_subdevice_type(comedi_t*, unsigned subdevice) {
  const bool goes_both_ways = subdevice >= 2 && eha::hal::testing::stand_in_card().port_lines > 0;
  return goes_both_ways ? COMEDI_SUBD_DIO : kTypes.at(subdevice);
}
int comedi_get_subdevice_flags(comedi_t*, unsigned subdevice) { return subdevice == 0 ? SDF_DIFF : SDF_GROUND; }
int comedi_get_n_channels(comedi_t*, unsigned) { return 16; }
int comedi_range_is_chan_specific(comedi_t*, unsigned) { return 0; }
int comedi_maxdata_is_chan_specific(comedi_t*, unsigned) { return 0; }
lsampl_t comedi_get_maxdata(comedi_t*, unsigned, unsigned) { return kLastCode; }
int comedi_get_n_ranges(comedi_t*, unsigned, unsigned) { return 1; }
comedi_range* comedi_get_range(comedi_t*, unsigned subdevice, unsigned, unsigned) {
  static std::array<comedi_range, 2> ranges{{{0.0, 10.0, UNIT_volt}, {-5.0, 5.0, UNIT_volt}}};
  return &ranges.at(subdevice == 1 ? 1 : 0);
}
int comedi_lock(comedi_t*, unsigned) { return 0; }
int comedi_dio_config(comedi_t*, unsigned subdevice, unsigned channel, unsigned direction) {
  auto& card = eha::hal::testing::stand_in_card();
  auto& lines = card.directions.at(subdevice);
  const std::size_t first = channel - channel % card.port_lines;
  for (std::size_t line = first; line < first + card.port_lines; ++line) lines.at(line) = direction;
  return 0;
}
int comedi_dio_get_config(comedi_t*, unsigned subdevice, unsigned channel, unsigned* direction) {
  *direction = eha::hal::testing::stand_in_card().directions.at(subdevice).at(channel);
  return 0;
}
int comedi_do_insn(comedi_t* device, comedi_insn* instruction) {
  if (device->removals < eha::hal::testing::stand_in_card().removals) return eha::hal::testing::fail(ENODEV);
  return eha::hal::testing::perform(*instruction);
}
int comedi_do_insnlist(comedi_t*, comedi_insnlist* list) {
  for (unsigned i = 0; i < list->n_insns; ++i) {
    if (eha::hal::testing::perform(list->insns[i]) < 0) return i == 0 ? -1 : static_cast<int>(i);
  }
  return static_cast<int>(list->n_insns);
}

}  // extern "C"
