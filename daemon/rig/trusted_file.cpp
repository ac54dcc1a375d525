// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/trusted_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/own_folder.hpp"
#include "core/shell_word.hpp"
#include "hal/backends/backend.hpp"

namespace eha {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSiteFolder = "/etc/ehad";

/// Whether uid 0 is another user outside, user_namespaces(7): the machine's own namespace maps every uid to itself.
bool is_in_user_namespace() {
  std::istringstream map(os::read_file("/proc/self/uid_map"));
  std::uint64_t inside = 1;
  std::uint64_t outside = 1;
  std::uint64_t count = 0;
  map >> inside >> outside >> count;
  return inside != 0 || outside != 0 || count < 0xFFFFFFFFU;
}

/// A rig file and its folder, both open, so that all checks concern the same file and folder even if links in the path
/// change meanwhile.
class OpenRigFile {
 public:
  explicit OpenRigFile(const config::RigConfig& rig)
      : rig_(rig), folder_(os::open_file(folder_of(rig.file_name), O_PATH | O_DIRECTORY)) {
    file_ = os::FileDescriptor(openat(folder_.get(), fs::path(rig.file_name).filename().c_str(), O_RDONLY | O_CLOEXEC));
    if (!file_) os::throw_system_error("open", rig.file_name, errno);
  }

  void require_trust() const {
    if (is_in_user_namespace()) {
      throw PermissionError(fmt::format(
          "{}: whether it belongs to root cannot be told within a user namespace, such as that of a rootless "
          "container, where every user may be root; drive the card outside of it, or use the service",
          rig_.file_name));
    }
    struct stat facts {};
    if (fstat(file_.get(), &facts) != 0) os::throw_system_error("look at", rig_.file_name, errno);
    if (!os::is_changed_only_by(facts, {0})) {
      throw PermissionError(
          fmt::format("{0}: a rig file that drives a real card must belong to root and be writable by no one else, "
                      "because its limits protect the machine; as root: chown root {1} && chmod go-w {1}",
                      rig_.file_name, shell_word(rig_.file_name)));
    }
    // The checked owner is that of the present file; the limits may have been read from another one.
    if (os::read_file(fmt::format("/proc/self/fd/{}", file_.get())) != rig_.text) {
      throw PermissionError(fmt::format("{}: the file changed while it was read; try again", rig_.file_name));
    }
  }

  [[nodiscard]] bool is_of_site() const {
    std::error_code error;
    const fs::path folder = fs::read_symlink(fmt::format("/proc/self/fd/{}", folder_.get()), error);
    return !error && lies_in_site(folder);
  }

  [[nodiscard]] static bool lies_in_site(const fs::path& folder) {
    std::error_code error;
    const fs::path site = fs::canonical(kSiteFolder, error);
    return !error && std::mismatch(site.begin(), site.end(), folder.begin(), folder.end()).first == site.end();
  }

 private:
  static fs::path folder_of(const std::string& file) {
    const fs::path folder = fs::path(file).parent_path();
    return folder.empty() ? fs::path(".") : folder;
  }

  const config::RigConfig& rig_;
  os::FileDescriptor folder_;
  os::FileDescriptor file_;
};

}  // namespace

void require_trusted_rig_file(const config::RigConfig& rig) {
  if (hal::moves_machine(rig.backend)) OpenRigFile(rig).require_trust();
}

bool is_site_rig_file(const std::string& file_name) {
  std::error_code error;
  const fs::path folder = fs::canonical(fs::absolute(file_name, error).parent_path(), error);
  return !error && OpenRigFile::lies_in_site(folder);
}

void require_local_rig_file(const config::RigConfig& rig) {
  if (!hal::moves_machine(rig.backend)) return;
  const OpenRigFile file(rig);
  file.require_trust();
  if (geteuid() == 0 || file.is_of_site()) return;
  throw PermissionError(
      fmt::format("{}: without the service, only root drives a card with a rig file outside {}; use the service, or "
                  "have root put the file of this rig there",
                  rig.file_name, kSiteFolder));
}

}  // namespace eha
