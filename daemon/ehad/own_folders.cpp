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
    const std::string owner = user_name(found.st_uid);
    // Who may write there decides what the service reads and removes.
    const bool others_may_write = (found.st_mode & S_IWOTH) != 0 && (found.st_mode & S_ISVTX) == 0;
    if ((found.st_uid != geteuid() && found.st_uid != 0 && geteuid() != 0) || others_may_write) {
      throw PermissionError(
          fmt::format("{}: {}, who could make the service remove files of yours; name a folder of "
                      "your own with {}",
                      folder.string(), others_may_write ? "any user may write there" : "belongs to " + owner, option));
    }
    if (geteuid() != 0 || found.st_uid == 0) return;
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
  prepare(of_socket.empty() ? "." : of_socket, "--socket DIR/ehad.sock (and EHA_SOCKET for eha)");
}

}  // namespace eha::service
