// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

constexpr const char* kSiteFolder = "/etc/ehad";

}  // namespace

void require_trusted_rig_file(const config::RigConfig& rig) {
  if (!hal::moves_machine(rig.backend)) return;
  const os::FileDescriptor file = os::open_file(rig.file_name, O_RDONLY);
  struct stat facts {};
  if (fstat(file.get(), &facts) != 0) os::throw_system_error("look at", rig.file_name, errno);
  if (facts.st_uid != 0 || (facts.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw PermissionError(
        fmt::format("{}: a rig file that drives a real card must belong to root and be writable by no one else, "
                    "because its limits protect the machine; as root: chown root {} && chmod go-w {}",
                    rig.file_name, rig.file_name, rig.file_name));
  }
  // The owner just checked is that of the file there now; the limits may have been read from another one.
  if (os::read_file(fmt::format("/proc/self/fd/{}", file.get())) != rig.text) {
    throw PermissionError(fmt::format("{}: the file changed while it was read; try again", rig.file_name));
  }
}

bool is_site_rig_file(const std::string& file_name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = fs::canonical(fs::absolute(file_name, error).parent_path(), error);
  const fs::path site = fs::canonical(kSiteFolder, error);
  return !error && std::mismatch(site.begin(), site.end(), folder.begin(), folder.end()).first == site.end();
}

void require_local_rig_file(const config::RigConfig& rig) {
  require_trusted_rig_file(rig);
  if (geteuid() == 0 || !hal::moves_machine(rig.backend) || is_site_rig_file(rig.file_name)) return;
  throw PermissionError(
      fmt::format("{}: without the service, only root drives a card with a rig file outside {}; use the service, or "
                  "have root put the file of this rig there",
                  rig.file_name, kSiteFolder));
}

}  // namespace eha
