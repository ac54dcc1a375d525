// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/user_namespace.hpp"

#include <fcntl.h>
#include <linux/magic.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <utility>

#include "core/os/file_descriptor.hpp"

namespace eha {
namespace {

/// Name of the first user namespace, whose number is fixed: USER_NS_INIT_INO of linux/nsfs.h, 0xEFFFFFFD.
constexpr std::string_view kFirst = "user:[4026531837]";
/// Number of the root folder of each proc, PROC_ROOT_INO of linux/proc_ns.h.
constexpr ino_t kRootOfProc = 1;

bool is_of_proc(const os::FileDescriptor& file) noexcept {
  struct statfs facts {};
  return file && fstatfs(file.get(), &facts) == 0 && facts.f_type == PROC_SUPER_MAGIC;
}

/// Opens /proc; none if it is a folder of something else, or one below the root of a proc.
os::FileDescriptor open_proc() noexcept {
  os::FileDescriptor proc(open("/proc", O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct statx facts {};
  if (!is_of_proc(proc) || statx(proc.get(), "", AT_EMPTY_PATH, STATX_INO, &facts) != 0) return {};
  const bool is_whole = (facts.stx_attributes & STATX_ATTR_MOUNT_ROOT) != 0 && facts.stx_ino == kRootOfProc;
  return is_whole ? std::move(proc) : os::FileDescriptor();
}

/// Opens a file of this process in /proc; none if anything is mounted on the way to it or over it. The root of a user
/// namespace may mount what it likes there: any file, and those of other processes.
os::FileDescriptor open_uncovered(const os::FileDescriptor& proc, const char* name, int flags) noexcept {
  open_how how{};
  how.flags = static_cast<std::uint64_t>(flags) | O_CLOEXEC;
  how.resolve = RESOLVE_NO_XDEV | RESOLVE_NO_MAGICLINKS;
  os::FileDescriptor file(static_cast<int>(syscall(SYS_openat2, proc.get(), name, &how, sizeof how)));
  return is_of_proc(file) ? std::move(file) : os::FileDescriptor();
}

/// Whether a map of uids maps every uid to itself.
bool maps_to_itself(const os::FileDescriptor& map) noexcept {
  std::array<char, 128> text{};
  if (read(map.get(), text.data(), text.size() - 1) <= 0) return false;
  unsigned long inside = 1;
  unsigned long outside = 1;
  unsigned long count = 0;
  return std::sscanf(text.data(), "%lu %lu %lu", &inside, &outside, &count) == 3 && inside == 0 && outside == 0 &&
         count == 0xFFFFFFFFUL;
}

}  // namespace

bool is_root_of_machine() noexcept {
  const os::FileDescriptor proc = open_proc();
  if (!proc) return false;
  // The text of the link itself: what it leads to lies on another mount, which RESOLVE_NO_XDEV does not reach.
  const os::FileDescriptor space = open_uncovered(proc, "self/ns/user", O_PATH | O_NOFOLLOW);
  std::array<char, 64> name{};
  const ssize_t size = space ? readlinkat(space.get(), "", name.data(), name.size()) : -1;
  if (size <= 0 || std::string_view(name.data(), static_cast<std::size_t>(size)) != kFirst) return false;
  const os::FileDescriptor map = open_uncovered(proc, "self/uid_map", O_RDONLY);
  return map && maps_to_itself(map);
}

}  // namespace eha
