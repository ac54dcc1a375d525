// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/run_folder.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/confined_reader.hpp"
#include "daemon/record/experiment_rows.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/resolved_path.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::record {
namespace {

using acquisition::TickRecord;

constexpr int kMostRunsPerSecond = 1000;

std::string file_safe(std::string_view name) {
  std::string safe(name.empty() ? "run" : name);
  for (char& letter : safe) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) == 0 && letter != '-' && letter != '_' && letter != '.') letter = '-';
  }
  return safe;
}

void require_unchanged(const std::filesystem::path& path, const Manifest& manifest) {
  if (!manifest.outcome) return;  // The journal of a run that is still going grows.
  for (const FileEntry& entry : manifest.files) {
    if (entry.path != path.filename().string()) continue;
    const auto bytes = entry.other.find("bytes");
    std::error_code unknown;
    const bool has_size = bytes == entry.other.end() || *bytes == std::filesystem::file_size(path, unknown);
    if (has_size && entry.sha256 == sha256_of_file(path)) return;
    throw DataError(os::shown(path) + ": changed since the run (its size or SHA-256 is not the one in " +
                    std::string(kManifestFile) + "); restore it, or move it away to read the journal instead");
  }
}

/// Calls consume(header, ticks) once for raw.h5, or once a block for the journal.
template <typename Consume>
void read_raw(const std::filesystem::path& folder, const Manifest& manifest, Consume&& consume) {
  // A pipe of that name would block its reader, and a device would have no end.
  if (std::filesystem::is_regular_file(folder / kRawFile)) {
    require_unchanged(folder / kRawFile, manifest);
    consume(read_raw_rows(folder / kRawFile));
    return;
  }
  const std::filesystem::path journal = folder / kJournalFile;
  if (!std::filesystem::is_regular_file(journal)) {
    throw IoError(os::shown(folder) + ": holds neither " + std::string(kRawFile) + " nor " + std::string(kJournalFile));
  }
  require_unchanged(journal, manifest);
  read_journal(journal, [&](std::span<const TickRecord> ticks) {
    consume(std::vector<TickRecord>(ticks.begin(), ticks.end()));
  });
}

}  // namespace

std::filesystem::path create_run_folder(const std::filesystem::path& runs_folder, std::string_view name) {
  os::create_folders(runs_folder);
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  const std::string stem = fmt::format("{:%Y%m%dT%H%M%SZ}-{}", fmt::gmtime(now), file_safe(name));
  for (int number = 1; number <= kMostRunsPerSecond; ++number) {
    const std::filesystem::path folder = runs_folder / (number == 1 ? stem : fmt::format("{}-{}", stem, number));
    if (::mkdir(folder.c_str(), 0755) == 0) {
      os::create_folders(folder / kModelsFolder);
      return folder;
    }
    if (errno != EEXIST) os::throw_system_error("create", folder, errno);
  }
  throw IoError("cannot create a run folder in " + runs_folder.string() + ": more than a thousand in this second");
}

bool is_run_folder(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(path, ignored)) return false;
  // A pipe of that name would block its reader.
  const std::filesystem::path manifest = path / kManifestFile;
  return std::filesystem::exists(manifest, ignored) ? std::filesystem::is_regular_file(manifest, ignored)
                                                    : std::filesystem::is_regular_file(path / kJournalFile, ignored);
}

LoadedRun read_run(const std::filesystem::path& folder, StillGoing still_going) {
  return read_run(OpenRun(folder), still_going);
}

LoadedRun read_run(const OpenRun& opened, StillGoing still_going) {
  LoadedRun run;
  run.folder = opened.path();
  run.opened = opened;
  run.manifest = read_manifest(opened.files());
  const bool is_read_so_far = !run.manifest.outcome && still_going == StillGoing::read &&
                              std::filesystem::exists(opened.files() / kJournalFile) &&
                              is_being_written(opened.files() / kJournalFile);
  if (!run.manifest.outcome && !is_read_so_far) {
    throw DataError(run.folder.string() +
                    ": the run is still going, or its process died; in the second case: eha runs recover");
  }
  run.outcome = run.manifest.outcome.value_or(acquisition::Outcome::completed);
  RunHeader header = read_run_header(run.manifest.other, (run.folder / kManifestFile).string());
  run.record.step_s = header.sample_period_s;
  run.samples_per_repetition = header.samples_per_repetition;
  run.repetitions = header.repetitions;
  run.experiment_text = std::move(header.experiment_text);
  run.rig_text = std::move(header.rig_text);
  std::vector<double> input;
  std::vector<double> output;
  ExperimentRows rows(run.folder.string(), [&](std::size_t, double voltage_V, double displacement_in) {
    input.push_back(voltage_V);
    output.push_back(displacement_in);
  });
  read_raw(opened.files(), run.manifest, [&](const std::vector<TickRecord>& ticks) { rows.add(ticks); });
  rows.finish();
  if (input.empty()) throw DataError(run.folder.string() + ": the run holds no row of the experiment");
  run.record.unmeasured = rows.interpolated();
  run.record.input = Eigen::Map<const Eigen::VectorXd>(input.data(), static_cast<Eigen::Index>(input.size()));
  run.record.output = Eigen::Map<const Eigen::VectorXd>(output.data(), static_cast<Eigen::Index>(output.size()));
  return run;
}

std::vector<TickRecord> read_ticks(const std::filesystem::path& folder) {
  const std::filesystem::path resolved = resolved_path(folder);
  std::vector<TickRecord> all;
  read_raw(resolved, read_manifest(resolved),
           [&](const std::vector<TickRecord>& ticks) { all.insert(all.end(), ticks.begin(), ticks.end()); });
  return all;
}

std::vector<std::filesystem::path> list_runs(const std::filesystem::path& runs_folder) {
  std::vector<std::filesystem::path> runs;
  std::error_code error;
  if (!std::filesystem::exists(runs_folder, error)) return runs;
  std::filesystem::directory_iterator entries(runs_folder, error);
  if (error) os::throw_system_error("list", runs_folder, error.value());
  for (const auto& entry : entries) {
    if (!entry.is_symlink() && is_run_folder(entry.path())) runs.push_back(entry.path());
  }
  std::sort(runs.begin(), runs.end());
  return runs;
}

std::string what_stands_for_latest(const OpenRun& run) {
  const std::filesystem::path link = run.beside() / kLatestLink;
  std::error_code unknown;
  const std::filesystem::file_status there = std::filesystem::symlink_status(link, unknown);
  if (!std::filesystem::exists(there) || std::filesystem::is_symlink(there)) return {};
  return fmt::format("{} is a {} and stays as it is", os::shown(link),
                     std::filesystem::is_directory(there) ? "folder" : "file");
}

void publish_latest(const OpenRun& run) {
  const std::filesystem::path link = run.beside() / kLatestLink;
  if (!what_stands_for_latest(run).empty()) return;
  std::filesystem::path temporary = link;
  temporary += "." + std::to_string(::getpid()) + ".tmp";
  ::unlink(temporary.c_str());
  if (::symlink(run.path().filename().c_str(), temporary.c_str()) != 0)
    os::throw_system_error("create", temporary, errno);
  if (::rename(temporary.c_str(), link.c_str()) != 0) {
    const int error_number = errno;
    ::unlink(temporary.c_str());
    os::throw_system_error("replace", link, error_number);
  }
}

}  // namespace eha::record
