// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <system_error>

#include "core/error.hpp"

namespace eha {

void require_trusted_rig_file(const config::RigConfig& rig) {
  if (rig.backend != config::Backend::comedi) return;
  struct stat facts {};
  if (stat(rig.file_name.c_str(), &facts) != 0) {
    throw PermissionError(fmt::format("cannot look at {}: {}", rig.file_name, std::generic_category().message(errno)));
  }
  if (facts.st_uid != 0 || (facts.st_mode & (S_IWGRP | S_IWOTH)) != 0) {
    throw PermissionError(
        fmt::format("{}: a rig file that drives a real card must belong to root and be writable by no one else, "
                    "because its limits protect the machine; as root: chown root {} && chmod go-w {}",
                    rig.file_name, rig.file_name, rig.file_name));
  }
}

}  // namespace eha
