// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/run_folder_check.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "core/error.hpp"

namespace eha::doctor {
namespace {

namespace fs = std::filesystem;

// A tick leaves 64 bytes in the journal and some 80 in raw.h5 and data_40ms.csv.
constexpr double kBytesPerTick = 144.0;
constexpr double kTooShort_s = 600.0;
constexpr double kShort_s = 3600.0;

ExitCode code_of(int error_number) {
  return error_number == EACCES || error_number == EPERM ? ExitCode::permission : ExitCode::io;
}

Check check_writable(const RunsFolder& runs) {
  if (runs.write_error == 0) return ok("runs folder", fmt::format("{} can be written", runs.folder.string()));
  return fail("runs folder",
              fmt::format("cannot write in {}: {}", runs.existing.string(), error_text(runs.write_error)),
              "choose another with --output, or ask its owner for permission to write", code_of(runs.write_error));
}

Check check_space(const RunsFolder& runs, double sample_period_s) {
  if (runs.space_error != 0) {
    return fail("disk space", fmt::format("unknown for {}: {}", runs.existing.string(), error_text(runs.space_error)),
                "choose another folder with --output", code_of(runs.space_error));
  }
  const double seconds = static_cast<double>(runs.available_bytes) / kBytesPerTick * sample_period_s;
  const std::string found = fmt::format("{:.1f} GB free: {:.1f} hours of ticks",
                                        static_cast<double>(runs.available_bytes) * 1e-9, seconds / 3600.0);
  const std::string remedy = "free space there, or choose another folder with --output";
  if (seconds < kTooShort_s) return fail("disk space", found, remedy, ExitCode::io);
  if (seconds < kShort_s) return warn("disk space", found, remedy);
  return ok("disk space", found);
}

}  // namespace

RunsFolder look_at_runs_folder(const fs::path& folder) {
  RunsFolder runs;
  runs.folder = folder;
  std::error_code unknown;
  runs.existing = fs::absolute(folder, unknown);
  while (!fs::exists(runs.existing, unknown) && runs.existing.has_relative_path()) {
    runs.existing = runs.existing.parent_path();
  }
  if (!fs::is_directory(runs.existing, unknown)) {
    runs.write_error = ENOTDIR;
  } else if (faccessat(AT_FDCWD, runs.existing.c_str(), W_OK | X_OK, AT_EACCESS) != 0) {
    runs.write_error = errno;
  }
  struct statvfs disk {};
  if (statvfs(runs.existing.c_str(), &disk) != 0) {
    runs.space_error = errno;
  } else {
    runs.available_bytes = static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
  }
  return runs;
}

std::vector<Check> check_runs_folder(const RunsFolder& runs, double sample_period_s) {
  return {check_writable(runs), check_space(runs, sample_period_s)};
}

}  // namespace eha::doctor
