// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/system/own_mounts.hpp"

#include <fcntl.h>
#include <linux/fs.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/mount.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>

namespace eha::test {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kDiskSize = 256U << 20U;

bool shell(const std::string& command) { return std::system((command + " > /dev/null 2>&1").c_str()) == 0; }

}  // namespace

bool has_own_mounts() {
  static const bool is_own =
      geteuid() == 0 && unshare(CLONE_NEWNS) == 0 && mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0;
  return is_own;
}

bool mount_disk(const fs::path& image, const fs::path& at) {
  std::ofstream(image).close();
  fs::resize_file(image, kDiskSize);
  return shell("mkfs.ext4 -q " + image.string()) &&
         shell("mount -o loop,errors=remount-ro " + image.string() + " " + at.string());
}

Mounted::~Mounted() { umount2(at_.c_str(), MNT_DETACH); }

Frozen::Frozen(const fs::path& at) : folder_(open(at.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (ioctl(folder_, FIFREEZE, 0) == 0) return;
  close(folder_);
  throw std::runtime_error("cannot freeze " + at.string());
}

Frozen::~Frozen() { thaw(); }

void Frozen::thaw() {
  if (folder_ < 0) return;
  ioctl(folder_, FITHAW, 0);
  close(folder_);
  folder_ = -1;
}

}  // namespace eha::test
