// SPDX-License-Identifier: GPL-3.0-or-later
#include "board.hpp"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace eha::test {
namespace {

[[noreturn]] void fail(const std::string& what) { throw std::runtime_error(what + ": " + std::strerror(errno)); }

std::string parameter_path(const std::string& module, const std::string& parameter) {
  return "/sys/module/" + module + "/parameters/" + parameter;
}

}  // namespace

Board::Board(std::string module, const char* parameters) : module_(std::move(module)) {
  const std::string path = "/modules/" + module_ + ".ko";
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) fail(path);
  const long loaded = syscall(SYS_finit_module, file, parameters, 0);
  close(file);
  if (loaded != 0) fail("loading " + path);
  if (!std::filesystem::exists("/dev/comedi0")) fail("/dev/comedi0");
}

Board::~Board() {
  if (syscall(SYS_delete_module, module_.c_str(), O_NONBLOCK) != 0) {
    std::cerr << "unloading " << module_ << ": " << std::strerror(errno) << "\n";
  }
}

void Board::set(const std::string& parameter, int value) const {
  std::ofstream file(parameter_path(module_, parameter));
  file << value << std::flush;
  if (!file) fail(parameter);
}

int Board::get(const std::string& parameter) const {
  std::ifstream file(parameter_path(module_, parameter));
  int value = 0;
  if (!(file >> value)) fail(parameter);
  return value;
}

Wire read_wire() {
  std::ifstream file("/proc/pci1716_wire");
  Wire wire;
  std::string key;
  std::int64_t ignored = 0;
  file >> key >> wire.ao0_uV >> key >> ignored >> key >> wire.digital_outputs;
  if (!file || key != "do") throw std::runtime_error("/proc/pci1716_wire is not as expected");
  return wire;
}

std::vector<WireChange> read_wire_changes() {
  std::ifstream file("/proc/pci1716_changes");
  std::vector<WireChange> changes;
  for (WireChange change; file >> change.time_ns >> change.wire >> change.value;) changes.push_back(change);
  if (changes.empty()) throw std::runtime_error("/proc/pci1716_changes is not as expected");
  return changes;
}

bool wire_is_safe() {
  const Wire wire = read_wire();
  return std::abs(static_cast<double>(wire.ao0_uV)) <= kHalfLsb_uV && (wire.digital_outputs & kEnableBit) == 0;
}

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::int64_t off_since_ns() {
  std::int64_t since_ns = kNeverOff;
  for (const WireChange& change : read_wire_changes()) {
    if (change.wire != "do") continue;
    if ((change.value & kEnableBit) != 0) {
      since_ns = kNeverOff;
    } else if (since_ns == kNeverOff) {
      since_ns = change.time_ns;
    }
  }
  return since_ns;
}

double true_place_in(const Board& board) {
  constexpr double kInPerVolt = 0.295;
  return 2.95 + kInPerVolt * 1e-6 * board.get("rod_uV");
}

}  // namespace eha::test
