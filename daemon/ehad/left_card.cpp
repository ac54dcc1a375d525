// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/left_card.hpp"

#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <exception>
#include <string_view>
#include <system_error>

#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "core/os/lock_file.hpp"
#include "hal/backends/backend.hpp"
#include "hal/snapshot_file.hpp"

namespace eha::service {
namespace {

/// A guard that still has the card needs less, unless it refuses.
constexpr std::chrono::seconds kPatience{3};

}  // namespace

std::filesystem::path snapshot_beside(const std::filesystem::path& socket) {
  return socket.parent_path() / "safe.json";
}

void make_left_card_safe(const std::filesystem::path& socket) noexcept {
  try {
    const std::filesystem::path snapshot = snapshot_beside(socket);
    std::error_code ignored;
    // Root must not act on a file by which another user's folder names volts and lines of a card.
    struct stat facts {};
    if (::lstat(snapshot.c_str(), &facts) != 0 || !S_ISREG(facts.st_mode) || facts.st_uid != geteuid()) return;
    // Who drives a card holds this file; root must not make one that the service cannot open.
    const std::filesystem::path lock_file = snapshot.parent_path() / "card.lock";
    os::FileDescriptor lock;
    try {
      if (std::filesystem::exists(lock_file, ignored)) lock = os::lock_file(lock_file, "");
    } catch (const Error&) {
      return;  // it is driven
    }
    const hal::SafeAction left = hal::safe_action(hal::read_safe_snapshot(snapshot), snapshot.string());
    const std::string done = left.make_safe(kPatience);
    std::filesystem::remove(snapshot, ignored);
    spdlog::warn("{}: left behind by a process before this one: {}", left.device, done);
  } catch (const std::exception& error) {
    spdlog::critical("THE OUTPUT OF THE CARD THAT A PROCESS BEFORE THIS ONE LEFT IS NOT CONFIRMED SAFE: {}",
                     error.what());
  }
}

}  // namespace eha::service
