// SPDX-License-Identifier: GPL-3.0-or-later
// eha-reader KIND NAME CPU_SECONDS MEMORY_BYTES: reads the file that is its descriptor 3 and hands its arrays over on
// standard output. The importer starts it; users do not.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <new>
#include <string>
#include <string_view>

#include "core/error.hpp"
#include "core/os/child_process.hpp"
#include "daemon/importer/foreign_reader.hpp"
#include "daemon/importer/reader_confinement.hpp"
#include "daemon/record/confined_reader.hpp"
#include "daemon/record/raw_hdf5.hpp"

namespace {

constexpr int kWords = 5;

bool limit(__rlimit_resource resource, rlim_t most) {
  rlimit limits{};
  if (getrlimit(resource, &limits) != 0) return false;
  // A fit by the service has limits of its own.
  limits.rlim_cur = limits.rlim_max = std::min(most, limits.rlim_max);
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

/// Sends what `send` reads of the file that is open, or why not.
void answer(const std::string& name, const char* memory_bytes,
            const std::function<void(const std::string& file)>& send) {
  std::string refusal;
  try {
    return send(fmt::format("/proc/self/fd/{}", eha::os::kSharedDescriptor));
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
  eha::record::send_refusal(STDOUT_FILENO, refusal);
}

/// What sends a file of that kind; none for an unknown kind.
std::function<void(const std::string& file)> sender_of(std::string_view kind, const std::string& name) {
  if (kind == eha::record::kRawRows) {
    return [name](const std::string& file) {
      eha::record::send_rows(STDOUT_FILENO, eha::record::read_raw_file(file, name).records);
    };
  }
  for (const eha::importer::ForeignReader& reader : eha::importer::kForeignReaders) {
    if (reader.kind != kind) continue;
    return [name, &reader](const std::string& file) {
      eha::importer::send_arrays(STDOUT_FILENO, reader.read(file, name));
    };
  }
  return {};
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
    if (const auto send = sender_of(argv[1], argv[2])) {
      if (!eha::importer::confine_to(eha::os::kSharedDescriptor)) {
        std::fputs("eha-reader: error: this kernel does not filter system calls\n", stderr);
        return static_cast<int>(eha::ExitCode::io);
      }
      try {
        answer(argv[2], argv[4], send);
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
