// SPDX-License-Identifier: GPL-3.0-or-later
// To be loaded before libcomedi into the programs under test: a card in shared memory, so that a process outside sees
// what each of them does to it and when.
#include "tests/system/stand_in_card.hpp"

#include <comedilib.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>

struct comedi_t_struct {
  int descriptor = -1;
  std::uint32_t removals = 0;  ///< of the card when this was opened
};

namespace {

using eha::test::CardMemory;

constexpr std::array kTypes{COMEDI_SUBD_AI, COMEDI_SUBD_AO, COMEDI_SUBD_DI, COMEDI_SUBD_DO};
constexpr lsampl_t kLastCode = 65535;
// The rod: 0..5.9 in over the sensor's -10..10 V.
constexpr double kStroke_in = 5.9;

thread_local int last_error = 0;

int fail(int error) {
  last_error = error;
  return -1;
}

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

CardMemory* map() {
  const char* path = std::getenv(eha::test::kCardFile);
  if (path == nullptr) return nullptr;
  const int file = open(path, O_RDWR | O_CLOEXEC);
  if (file < 0) return nullptr;
  void* memory = mmap(nullptr, sizeof(CardMemory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file, 0);
  close(file);
  return memory != MAP_FAILED ? static_cast<CardMemory*>(memory) : nullptr;
}

CardMemory& card() {
  static CardMemory* const memory = map();
  if (memory == nullptr) std::abort();
  return *memory;
}

/// One call of the kernel's driver: nobody else reaches the card during it.
class Call {
 public:
  Call() {
    // A thread that a debugger halts in here would keep the mutex; in the kernel it is not halted.
    const std::int64_t deadline_ns = now_ns() + 2'000'000'000;
    const timespec deadline{deadline_ns / 1'000'000'000, deadline_ns % 1'000'000'000};
    const int error = pthread_mutex_clocklock(&card().mutex, CLOCK_MONOTONIC, &deadline);
    if (error == EOWNERDEAD) pthread_mutex_consistent(&card().mutex);
    is_held_ = error == 0 || error == EOWNERDEAD;
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  ~Call() {
    if (is_held_) pthread_mutex_unlock(&card().mutex);
  }
  [[nodiscard]] bool is_held() const { return is_held_; }

 private:
  bool is_held_ = false;
};

/// Locks of subdevices are those of the byte of the same number, which go with the descriptor.
struct flock lock_of(unsigned subdevice) {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = subdevice;
  lock.l_len = 1;
  return lock;
}

bool is_locked_by_another(const comedi_t* device, unsigned subdevice) {
  struct flock lock = lock_of(subdevice);
  return fcntl(device->descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

lsampl_t read_sensor() {
  CardMemory& memory = card();
  const std::int64_t now = now_ns();
  const double output_V = -5.0 + 10.0 * memory.output_code.load() / kLastCode;
  const double volts = std::copysign(std::max(0.0, std::abs(output_V) - memory.dead_band_V.load()), output_V);
  const double elapsed_s = memory.moved_ns == 0 ? 0.0 : static_cast<double>(now - memory.moved_ns) * 1e-9;
  memory.moved_ns = now;
  if (memory.is_enabled()) {
    memory.position_in =
        std::clamp(memory.position_in + CardMemory::kGain_in_per_V_s * volts * elapsed_s, 0.0, kStroke_in);
  }
  // One bit of noise, without which a sensor counts as frozen.
  memory.dither ^= 1U;
  return static_cast<lsampl_t>(std::lround(memory.position_in / kStroke_in * kLastCode)) + memory.dither;
}

int write_output(lsampl_t code) {
  CardMemory& memory = card();
  if (now_ns() < memory.refuses_until_ns.load()) return fail(EIO);
  if (const std::int64_t stall_ms = memory.output_stall_ms.load(); stall_ms > 0) {
    std::int64_t none = 0;
    const std::int64_t begun_ns = now_ns();
    memory.stall_begun_ns.compare_exchange_strong(none, begun_ns);
    // As the kernel does: it asks the converter again and again.
    while (now_ns() - begun_ns < stall_ms * 1'000'000) {
    }
    return fail(ETIME);
  }
  memory.output_code = code;
  memory.output_ns = now_ns();
  return 1;
}

int write_lines(lsampl_t mask, lsampl_t levels) {
  CardMemory& memory = card();
  if (now_ns() < memory.refuses_until_ns.load()) return fail(EIO);
  const bool was_enabled = memory.is_enabled();
  memory.digital_outputs = (memory.digital_outputs & ~mask) | (levels & mask);
  if (was_enabled && !memory.is_enabled()) memory.disabled_ns = now_ns();
  if (!was_enabled && memory.is_enabled()) memory.enabled_ns = now_ns();
  return 1;
}

int perform(const comedi_t* device, const comedi_insn& instruction) {
  if (instruction.insn == INSN_WAIT) return 1;
  if (device->removals < card().removals.load()) return fail(ENODEV);
  if (is_locked_by_another(device, instruction.subdev)) return fail(EACCES);
  switch (instruction.subdev) {
    case 0:
      if (instruction.insn == INSN_READ && instruction.n > 0) instruction.data[0] = read_sensor();
      return 1;
    case 1:
      return write_output(instruction.data[0]);
    case 2:
      instruction.data[1] = card().digital_inputs.load();
      return 1;
    default:
      return write_lines(instruction.data[0], instruction.data[1]);
  }
}

}  // namespace

extern "C" {

comedi_t* comedi_open(const char*) {
  const char* path = std::getenv(eha::test::kCardFile);
  if (path == nullptr) return nullptr;
  if (const int error = card().open_error.load(); error != 0) {
    last_error = error;
    return nullptr;
  }
  return new comedi_t_struct{open(path, O_RDWR), card().removals.load()};
}
int comedi_close(comedi_t* device) {
  const int result = close(device->descriptor);
  delete device;
  return result;
}
int comedi_fileno(comedi_t* device) { return device->descriptor; }
int comedi_loglevel(int) { return 0; }
int comedi_errno() { return last_error; }
const char* comedi_strerror(int) { return "refused by the stand-in"; }
comedi_oor_behavior comedi_set_global_oor_behavior(comedi_oor_behavior) { return COMEDI_OOR_NUMBER; }
const char* comedi_get_board_name(comedi_t*) { return "pci1716"; }
const char* comedi_get_driver_name(comedi_t*) { return "adv_pci1710"; }
int comedi_get_n_subdevices(comedi_t*) { return static_cast<int>(kTypes.size()); }
int comedi_get_subdevice_type(comedi_t*, unsigned subdevice) { return kTypes.at(subdevice); }
int comedi_get_subdevice_flags(comedi_t*, unsigned subdevice) { return subdevice == 0 ? SDF_DIFF : SDF_GROUND; }
int comedi_get_n_channels(comedi_t*, unsigned) { return 16; }
int comedi_range_is_chan_specific(comedi_t*, unsigned) { return 0; }
int comedi_maxdata_is_chan_specific(comedi_t*, unsigned) { return 0; }
lsampl_t comedi_get_maxdata(comedi_t*, unsigned, unsigned) { return kLastCode; }
int comedi_get_n_ranges(comedi_t*, unsigned, unsigned) { return 1; }
comedi_range* comedi_get_range(comedi_t*, unsigned subdevice, unsigned, unsigned) {
  static std::array<comedi_range, 2> ranges{{{-10.0, 10.0, UNIT_volt}, {-5.0, 5.0, UNIT_volt}}};
  return &ranges.at(subdevice == 1 ? 1 : 0);
}
int comedi_lock(comedi_t* device, unsigned subdevice) {
  struct flock lock = lock_of(subdevice);
  return fcntl(device->descriptor, F_OFD_SETLK, &lock) == 0 ? 0 : fail(EACCES);
}
int comedi_dio_config(comedi_t*, unsigned, unsigned, unsigned) { return 0; }
int comedi_dio_get_config(comedi_t*, unsigned, unsigned, unsigned*) { return 0; }
int comedi_do_insn(comedi_t* device, comedi_insn* instruction) {
  const Call call;
  return call.is_held() ? perform(device, *instruction) : fail(EBUSY);
}
int comedi_do_insnlist(comedi_t* device, comedi_insnlist* list) {
  const Call call;
  if (!call.is_held()) return fail(EBUSY);
  for (unsigned i = 0; i < list->n_insns; ++i) {
    if (perform(device, list->insns[i]) < 0) return i == 0 ? -1 : static_cast<int>(i);
    // The loop writes by lists; whoever makes the card safe does not.
    if (list->insns[i].subdev == 1) ++card().commands;
  }
  return static_cast<int>(list->n_insns);
}

}  // extern "C"
