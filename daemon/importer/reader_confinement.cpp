// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/reader_confinement.hpp"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace eha::importer {
namespace {

/// What readers, their libraries and the C library call; everything else fails with EPERM. Not ioctl, which could type
/// into the user's terminal. Calls with an argument that decides are in kArguments.
constexpr int kCalls[] = {
    SYS_read,           SYS_write,        SYS_pread64,         SYS_readv,
    SYS_writev,         SYS_lseek,        SYS_close,           SYS_fstat,
    SYS_newfstatat,     SYS_statx,        SYS_flock,           SYS_readlinkat,
    SYS_faccessat,      SYS_faccessat2,   SYS_getcwd,          SYS_brk,
    SYS_mmap,           SYS_munmap,       SYS_mremap,          SYS_mprotect,
    SYS_madvise,        SYS_futex,        SYS_getrandom,       SYS_getpid,
    SYS_gettid,         SYS_getuid,       SYS_geteuid,         SYS_getgid,
    SYS_getegid,        SYS_getrusage,    SYS_clock_gettime,   SYS_clock_nanosleep,
    SYS_gettimeofday,   SYS_uname,        SYS_sysinfo,         SYS_rt_sigaction,
    SYS_rt_sigprocmask, SYS_rt_sigreturn, SYS_sigaltstack,     SYS_sched_yield,
    SYS_exit,           SYS_exit_group,   SYS_restart_syscall,
#ifdef SYS_stat  // of architectures older than these calls with a folder
    SYS_stat,           SYS_lstat,        SYS_access,          SYS_readlink,
    SYS_time,
#endif
};

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#elif defined(__i386__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_I386;
#elif defined(__riscv)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_RISCV64;
#else
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_ARM;
#endif

/// open() to read only, in its two forms.
struct Opening {
  std::uint32_t call;
  std::uint32_t flags_at;  ///< the argument
};
constexpr Opening kOpenings[] = {
    {SYS_openat, 2},
#ifdef SYS_open
    {SYS_open, 1},
#endif
};

/// Calls that are allowed with these values of an argument only. fcntl() could make the kernel send a signal to another
/// process (F_SETOWN with F_SETSIG), prlimit64() take another process's time or memory away.
struct Argument {
  std::uint32_t call;
  std::uint32_t at;
  std::uint32_t value;
};
constexpr Argument kArguments[] = {
    {SYS_fcntl, 1, F_GETFD}, {SYS_fcntl, 1, F_SETFD},  {SYS_fcntl, 1, F_GETFL},         {SYS_fcntl, 1, F_GETLK},
    {SYS_fcntl, 1, F_SETLK}, {SYS_fcntl, 1, F_SETLKW}, {SYS_fcntl, 1, F_DUPFD_CLOEXEC}, {SYS_prlimit64, 0, 0},
};

constexpr sock_filter statement(std::uint32_t code, std::uint32_t value) {
  return {static_cast<std::uint16_t>(code), 0, 0, value};
}
constexpr sock_filter jump(std::uint32_t test, std::uint32_t value, std::uint8_t yes, std::uint8_t no) {
  return {static_cast<std::uint16_t>(BPF_JMP | test | BPF_K), yes, no, value};
}
constexpr sock_filter load(std::size_t at) {
  return statement(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(at));
}

/// @param own  this process: abort() signals itself
bool filter_calls(pid_t own) noexcept {
  constexpr sock_filter kAllow = statement(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  constexpr sock_filter kRefuse = statement(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EPERM);
  constexpr std::size_t kOfOpening = 5;
  constexpr std::size_t kOfArgument = 5;
  constexpr std::size_t kMostInstructions =
      5 + kOfOpening * std::size(kOpenings) + kOfArgument * (std::size(kArguments) + 1) + 2 * std::size(kCalls);
  std::array<sock_filter, kMostInstructions> filter{};
  std::size_t length = 0;
  const auto add = [&](sock_filter instruction) { filter[length++] = instruction; };
  add(load(offsetof(seccomp_data, arch)));
  add(jump(BPF_JEQ, kArchitecture, 1, 0));
  add(kRefuse);
  add(load(offsetof(seccomp_data, nr)));
  for (const int call : kCalls) {
    add(jump(BPF_JEQ, static_cast<std::uint32_t>(call), 0, 1));
    add(kAllow);
  }
  const auto allow_with = [&](const Argument& argument) {
    add(jump(BPF_JEQ, argument.call, 0, kOfArgument - 1));
    add(load(offsetof(seccomp_data, args) + argument.at * sizeof(std::uint64_t)));  // the low half: an int
    add(jump(BPF_JEQ, argument.value, 0, 1));
    add(kAllow);
    add(load(offsetof(seccomp_data, nr)));
  };
  for (const Argument& argument : kArguments) allow_with(argument);
  allow_with({SYS_tgkill, 0, static_cast<std::uint32_t>(own)});
  for (const Opening& opening : kOpenings) {
    add(jump(BPF_JEQ, opening.call, 0, kOfOpening - 1));
    add(load(offsetof(seccomp_data, args) + opening.flags_at * sizeof(std::uint64_t)));  // the low half
    add(jump(BPF_JSET, O_WRONLY | O_RDWR | O_CREAT | O_TRUNC, 0, 1));
    add(kRefuse);
    add(kAllow);
  }
  add(kRefuse);
  const sock_fprog program{static_cast<unsigned short>(length), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

void restrict_files(int descriptor) noexcept {
  landlock_ruleset_attr every{};
  every.handled_access_fs = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1;  // what the first version knows
  const auto rules = static_cast<int>(syscall(SYS_landlock_create_ruleset, &every, sizeof every, 0));
  if (rules < 0) return;
  landlock_path_beneath_attr one{};
  one.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE;
  one.parent_fd = descriptor;
  // A file without a folder needs no rule.
  syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &one, 0);
  syscall(SYS_landlock_restrict_self, rules, 0);
  close(rules);
}

}  // namespace

bool confine_to(int descriptor) noexcept {
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return false;
  restrict_files(descriptor);
  return filter_calls(getpid());
}

}  // namespace eha::importer
