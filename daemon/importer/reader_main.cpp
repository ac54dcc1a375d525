// SPDX-License-Identifier: GPL-3.0-or-later
// eha-reader KIND NAME CPU_SECONDS MEMORY_BYTES: reads the file that is its descriptor 3 and hands its arrays over on
// standard output. The importer starts it; users do not.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/os/child_process.hpp"
#include "daemon/importer/foreign_reader.hpp"
#include "daemon/importer/reader_confinement.hpp"

namespace {

constexpr int kWords = 5;

bool limit(__rlimit_resource resource, rlim_t most) {
  const rlimit limits{most, most};
  return setrlimit(resource, &limits) == 0;
}

bool limit_all(const char* cpu_seconds, [[maybe_unused]] const char* memory_bytes) {
  bool is_limited = limit(RLIMIT_CPU, std::strtoull(cpu_seconds, nullptr, 10)) && limit(RLIMIT_CORE, 0);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  // A sanitizer's shadow takes terabytes of addresses.
  is_limited = is_limited && limit(RLIMIT_AS, std::strtoull(memory_bytes, nullptr, 10));
#endif
  // It reads what is open and writes to its pipe: nothing of a file may have it do more.
  return is_limited && limit(RLIMIT_FSIZE, 0) && prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
         prctl(PR_SET_PDEATHSIG, SIGKILL) == 0;
}

void read(const eha::importer::ForeignReader& reader, const std::string& name, const char* memory_bytes) {
  const std::string file = fmt::format("/proc/self/fd/{}", eha::os::kSharedDescriptor);
  std::string refusal;
  try {
    return send_arrays(STDOUT_FILENO, reader.read(file, name));
  } catch (const std::bad_alloc&) {
    refusal = fmt::format(
        "{}: reading it takes more than {} MiB of memory: damaged, or made of numbers that a small file cannot hold; "
        "export the record as CSV",
        name, std::strtoull(memory_bytes, nullptr, 10) >> 20U);
  } catch (const eha::DataError& error) {
    refusal = error.what();
  } catch (const std::exception& error) {
    refusal = fmt::format("{}: cannot be read: {}; save it again", name, error.what());
  }
  eha::importer::send_refusal(STDOUT_FILENO, refusal);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == kWords && limit_all(argv[3], argv[4])) {
    // Formats would round numbers and times.
    if (eha::importer::kWorkbook == argv[1]) {
      execl(eha::importer::kWorkbookProgram, eha::importer::kWorkbookProgram, "--ignore-formats", "date", "time",
            "float", "percentage", "--", "/proc/self/fd/3", static_cast<char*>(nullptr));
      return static_cast<int>(eha::ExitCode::io);
    }
    for (const eha::importer::ForeignReader& reader : eha::importer::kForeignReaders) {
      if (reader.kind != argv[1]) continue;
      if (!eha::importer::confine_to(eha::os::kSharedDescriptor)) {
        std::fputs("eha-reader: error: this kernel does not filter system calls\n", stderr);
        return static_cast<int>(eha::ExitCode::io);
      }
      try {
        read(reader, argv[2], argv[4]);
        return 0;
      } catch (const std::exception& error) {
        std::fprintf(stderr, "eha-reader: error: %s\n", error.what());
        return static_cast<int>(eha::ExitCode::io);
      }
    }
  }
  std::fputs("eha-reader: error: to be started by eha only; see eha import\n", stderr);
  return static_cast<int>(eha::ExitCode::usage);
}
