// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/own_folders.hpp"

#include <fmt/format.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

std::string user_name(uid_t uid) {
  const passwd* known = getpwuid(uid);
  return known != nullptr ? known->pw_name : fmt::format("uid {}", uid);
}

/// @param option  that names another folder
void prepare(const fs::path& folder, std::string_view option) {
  struct stat found {};
  if (stat(folder.c_str(), &found) == 0) {
    if (geteuid() != 0 || found.st_uid == 0) return;
    const std::string owner = user_name(found.st_uid);
    throw PermissionError(fmt::format(
        "{}: belongs to {}; files of root in this folder would block the service of that user. Start the service "
        "(systemctl start ehad), run ehad as its user (runuser -u {} -- ehad ...), or name another folder with {}",
        folder.string(), owner, owner, option));
  }
  try {
    os::create_folders(folder);
  } catch (const Error& error) {
    throw Error(error.exit_code(),
                fmt::format("{}; start the service (systemctl start ehad), or name a folder of your own with {}",
                            error.what(), option));
  }
}

}  // namespace

void prepare_folders(const Options& options) {
  prepare(options.state, "--state DIR");
  const fs::path of_socket = options.socket.parent_path();
  if (!of_socket.empty()) prepare(of_socket, "--socket DIR/ehad.sock (and EHA_SOCKET for eha)");
}

}  // namespace eha::service
