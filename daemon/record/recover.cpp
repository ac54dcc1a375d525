// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/recover.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <optional>
#include <span>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/writer_lock.hpp"
#include "core/shell_word.hpp"
#include "core/terminal_text.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/plain_files.hpp"
#include "daemon/record/run_files.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {
namespace {

using acquisition::Outcome;

/// None if it cannot be read; the journal's header has the same content.
std::optional<Manifest> manifest_of(const std::filesystem::path& folder) {
  try {
    return read_manifest(folder);
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Whether a run lacks what is made at its end, be it still going or torn.
bool is_unfinished(const std::filesystem::path& folder) {
  const std::optional<Manifest> manifest = manifest_of(folder);
  // Done after any outcome: on a full disk only the journal may have been written.
  return (!manifest || !manifest->outcome || !std::filesystem::exists(folder / kRawFile)) &&
         std::filesystem::exists(folder / kJournalFile);
}

bool is_complete(const std::filesystem::path& folder, const std::optional<Manifest>& manifest) {
  return manifest && manifest->outcome && manifest->outcome != Outcome::write_failed &&
         std::filesystem::exists(folder / kRawFile);
}

/// From the journal's end; without one, from the manifest if it was written after the run.
Outcome outcome_of(const JournalFacts& facts, const Manifest& manifest, const std::string& source) {
  const Outcome outcome = facts.end ? outcome_from_text(facts.end->value("outcome", ""), source)
                                    : manifest.outcome.value_or(Outcome::recovered);
  return acquisition::is_whole(outcome) && !facts.gaps.empty() ? Outcome::recovered : outcome;
}

/// Frees what a killed writer had reserved beyond the rows, unless somebody has the journal's lock, who may append to
/// it: also the one (flock) that a program of before an upgrade has. Without it only room is lost.
void give_room_back(const std::filesystem::path& journal) {
  const os::FileDescriptor file(::open(journal.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (file.get() < 0 || !os::take_writer_lock(file, journal) || ::flock(file.get(), LOCK_EX | LOCK_NB) != 0) return;
  struct stat facts {};
  if (::fstat(file.get(), &facts) != 0) return;
  [[maybe_unused]] const int cut = ::ftruncate(file.get(), facts.st_size);
}

/// The first fault of a run by its rows, which have it from its tick on; none of a run without one.
acquisition::Fault fault_of_rows(const std::filesystem::path& journal) {
  acquisition::Fault fault = acquisition::Fault::none;
  read_journal(journal, [&](std::span<const acquisition::TickRecord> rows) {
    if (fault == acquisition::Fault::none && !rows.empty()) fault = rows.back().fault;
  });
  return fault;
}

void count_rows(Recovery& recovery, const JournalFacts& facts) {
  recovery.rows = facts.rows - facts.lost_rows;
  recovery.lost_rows = facts.lost_rows;
  recovery.gaps = facts.gaps.size();
  recovery.torn_bytes = facts.torn_bytes;
}

}  // namespace

Recovery recover_run(const std::filesystem::path& folder) {
  require_plain_files(folder);
  const std::filesystem::path journal = folder / kJournalFile;
  if (!std::filesystem::exists(journal)) {
    throw IoError(folder.string() + ": no " + std::string(kJournalFile) + " to recover from");
  }
  if (is_being_written(journal)) {
    throw IoError(folder.string() + ": the run is still going in another process; stop it first");
  }
  const std::optional<Manifest> old_manifest = manifest_of(folder);
  Recovery recovery;
  if (is_complete(folder, old_manifest)) {
    const JournalFacts facts = read_journal(journal, [](auto) {});
    count_rows(recovery, facts);
    recovery.outcome = *old_manifest->outcome;
    return recovery;
  }
  os::remove_temporary_files(folder);
  give_room_back(journal);
  const JournalFacts facts = write_files_from_journal(folder);
  Manifest manifest = old_manifest ? *old_manifest : manifest_from_header(facts.header);
  recovery.changed = true;
  count_rows(recovery, facts);
  recovery.outcome = outcome_of(facts, manifest, journal.string());
  manifest.outcome = recovery.outcome;
  manifest.recovery = {.utc = utc_now(),
                       .rows = recovery.rows,
                       .torn_bytes = facts.torn_bytes,
                       .end = facts.end.value_or(nullptr),
                       .gaps = facts.gaps};
  if (const auto fault = facts.end ? acquisition::Fault::none : fault_of_rows(journal);
      fault != acquisition::Fault::none) {
    manifest.other[kFaultOfRows] = acquisition::to_text(fault);
  }
  manifest.files.clear();
  write_manifest(folder, manifest);
  return recovery;
}

bool is_torn_run(const std::filesystem::path& folder) {
  return is_unfinished(folder) && !is_being_written(folder / kJournalFile);
}

std::vector<std::filesystem::path> find_torn_runs(const std::filesystem::path& runs_folder) {
  std::vector<std::filesystem::path> torn;
  for (const std::filesystem::path& folder : list_runs(runs_folder)) {
    if (is_torn_run(folder)) torn.push_back(folder);
  }
  return torn;
}

std::string describe(const std::filesystem::path& folder, const Recovery& recovery) {
  const std::string lost = recovery.gaps == 0 ? ""
                                              : fmt::format(" {} rows lost in {} damaged {},", recovery.lost_rows,
                                                            recovery.gaps, recovery.gaps == 1 ? "place" : "places");
  return fmt::format("{}: recovered: {} rows kept,{} {} torn bytes left out, outcome {}", one_line(folder.string()),
                     recovery.rows, lost, recovery.torn_bytes, acquisition::to_text(recovery.outcome));
}

void recover_torn_runs(const std::filesystem::path& runs_folder, const RecoveryMessages& messages) {
  for (const std::filesystem::path& folder : list_runs(runs_folder)) {
    try {
      if (!is_unfinished(folder)) continue;
      if (is_being_written(folder / kJournalFile)) {
        if (messages.skipped) {
          messages.skipped(one_line(folder.string()) +
                           ": not recovered: another process is writing it; once that has "
                           "ended: eha runs recover " +
                           shell_word(folder.string()));
        }
        continue;
      }
      if (messages.before_each) messages.before_each();
      messages.recovered(describe(folder, recover_run(folder)));
    } catch (const std::exception& error) {
      messages.failed(folder.string() + ": cannot be recovered: " + error.what());
    }
  }
}

}  // namespace eha::record
