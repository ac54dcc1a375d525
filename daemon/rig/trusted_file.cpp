// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "hal/backend.hpp"

namespace eha {

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

}  // namespace eha
