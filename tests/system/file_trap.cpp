// SPDX-License-Identifier: GPL-3.0-or-later
// Loaded before the C library into ehad and its workers: counts the operations that change a file under EHA_TRAP_UNDER,
// from the write of the journal's end on, over all of these processes, and kills them before the operation that the
// control file (EHA_TRAP_CONTROL) asks for. It appends each operation to the file EHA_TRAP_LOG.
#include "tests/system/file_trap.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

using eha::test::FileTrapControl;

template <typename F>
F next(const char* name) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

FileTrapControl* map_control() {
  const char* path = std::getenv("EHA_TRAP_CONTROL");
  if (path == nullptr) return nullptr;
  const auto file = static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC));
  if (file < 0) return nullptr;
  void* memory = mmap(nullptr, sizeof(FileTrapControl), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  syscall(SYS_close, file);
  if (memory == MAP_FAILED) return nullptr;
  auto* control = static_cast<FileTrapControl*>(memory);
  if (std::strcmp(program_invocation_short_name, "ehad") == 0) control->service = getpid();
  return control;
}

FileTrapControl* control() {
  static FileTrapControl* const mapped = map_control();
  return mapped;
}

void note(const char* operation, const char* path) {
  char line[PATH_MAX + 64];
  const int size = std::snprintf(line, sizeof line, "%s %s %s\n", program_invocation_short_name, operation, path);
  static const auto log = static_cast<int>(
      syscall(SYS_openat, AT_FDCWD, std::getenv("EHA_TRAP_LOG"), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600));
  syscall(SYS_write, log, line, static_cast<std::size_t>(size));
}

/// Counts an operation, or kills.
void count(const char* operation, const char* path) {
  const int saved = errno;
  const char* under = std::getenv("EHA_TRAP_UNDER");
  FileTrapControl* const shared = control();
  if (shared != nullptr && under != nullptr && shared->is_armed && std::strncmp(path, under, std::strlen(under)) == 0) {
    if (shared->count++ == shared->kill_before) {
      // The service first: it must not learn how its worker ended.
      kill(shared->service, SIGKILL);
      kill(getpid(), SIGKILL);
    }
    note(operation, path);
  }
  errno = saved;
}

void count(const char* operation, int file) {
  char link[64];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  char path[PATH_MAX];
  const ssize_t size = readlink(link, path, sizeof path - 1);
  if (size < 0) return;
  path[size] = '\0';
  count(operation, path);
}

void arm(const void* bytes, std::size_t size) {
  if (size >= 4 && std::memcmp(bytes, "EHAE", 4) == 0 && control() != nullptr) control()->is_armed = true;
}

template <typename F>
int open_as(F real, const char* name, const char* path, int flags, va_list rest) {
  if ((flags & (O_CREAT | O_TRUNC)) != 0) count(name, path);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(rest, mode_t) : 0;
  return real(path, flags, mode);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int file = open_as(next<int (*)(const char*, int, ...)>("open"), "open", path, flags, rest);
  va_end(rest);
  return file;
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int file = open_as(next<int (*)(const char*, int, ...)>("open64"), "open", path, flags, rest);
  va_end(rest);
  return file;
}

ssize_t write(int file, const void* bytes, std::size_t size) {
  arm(bytes, size);
  count("write", file);
  return next<decltype(&write)>("write")(file, bytes, size);
}

ssize_t pwrite(int file, const void* bytes, std::size_t size, off_t offset) {
  count("pwrite", file);
  return next<decltype(&pwrite)>("pwrite")(file, bytes, size, offset);
}

ssize_t pwrite64(int file, const void* bytes, std::size_t size, off64_t offset) {
  count("pwrite", file);
  return next<decltype(&pwrite64)>("pwrite64")(file, bytes, size, offset);
}

ssize_t writev(int file, const iovec* parts, int number) {
  count("writev", file);
  return next<decltype(&writev)>("writev")(file, parts, number);
}

int ftruncate(int file, off_t size) noexcept {
  count("ftruncate", file);
  return next<decltype(&ftruncate)>("ftruncate")(file, size);
}

int ftruncate64(int file, off64_t size) noexcept {
  count("ftruncate", file);
  return next<decltype(&ftruncate64)>("ftruncate64")(file, size);
}

int fallocate(int file, int mode, off_t offset, off_t size) {
  count("fallocate", file);
  return next<decltype(&fallocate)>("fallocate")(file, mode, offset, size);
}

int fsync(int file) {
  count("fsync", file);
  return next<decltype(&fsync)>("fsync")(file);
}

int fdatasync(int file) {
  count("fdatasync", file);
  return next<decltype(&fdatasync)>("fdatasync")(file);
}

int rename(const char* from, const char* to) noexcept {
  count("rename", to);
  return next<decltype(&rename)>("rename")(from, to);
}

int unlink(const char* path) noexcept {
  count("unlink", path);
  return next<decltype(&unlink)>("unlink")(path);
}

int remove(const char* path) noexcept {
  count("unlink", path);
  return next<decltype(&remove)>("remove")(path);
}

int symlink(const char* target, const char* path) noexcept {
  count("symlink", path);
  return next<decltype(&symlink)>("symlink")(target, path);
}

int mkdir(const char* path, mode_t mode) noexcept {
  count("mkdir", path);
  return next<decltype(&mkdir)>("mkdir")(path, mode);
}
}
