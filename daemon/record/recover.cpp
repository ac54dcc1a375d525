// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/recover.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "daemon/record/journal.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_files.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::record {
namespace {

using acquisition::Outcome;
using Json = nlohmann::ordered_json;

/// A manifest that cannot be read is as good as none: the journal's header says the same.
Json manifest_of(const std::filesystem::path& folder) {
  try {
    return read_manifest(folder);
  } catch (const Error&) {
    return Json();
  }
}

bool is_complete(const std::filesystem::path& folder, const Json& manifest) {
  if (!manifest.is_object() || !std::filesystem::exists(folder / kRawFile)) return false;
  const std::string outcome = manifest.value("outcome", "");
  return outcome != kInProgress && outcome != acquisition::to_text(Outcome::write_failed);
}

/// The journal's end knows how the run ended; without one the manifest does, if it was written after the run.
Outcome outcome_of(const JournalFacts& facts, const Json& manifest, const std::string& source) {
  if (facts.end) return outcome_from_text(facts.end->value("outcome", ""), source);
  const std::string outcome = manifest.value("outcome", "");
  return outcome == kInProgress ? Outcome::recovered : outcome_from_text(outcome, source);
}

}  // namespace

Recovery recover_run(const std::filesystem::path& folder) {
  const std::filesystem::path journal = folder / kJournalFile;
  if (!std::filesystem::exists(journal)) {
    throw IoError(folder.string() + ": no " + std::string(kJournalFile) + " to recover from");
  }
  if (is_being_written(journal)) {
    throw IoError(folder.string() + ": the run is still going in another process; stop it first");
  }
  Json manifest = manifest_of(folder);
  Recovery recovery;
  if (is_complete(folder, manifest)) {
    const JournalFacts facts = read_journal(journal, [](auto) {});
    recovery.rows = facts.rows;
    recovery.torn_bytes = facts.torn_bytes;
    recovery.outcome = outcome_from_text(manifest.value("outcome", ""), (folder / kManifestFile).string());
    return recovery;
  }
  const JournalFacts facts = write_files_from_journal(folder);
  if (!manifest.is_object()) manifest = manifest_from_header(facts.header);
  recovery.changed = true;
  recovery.rows = facts.rows;
  recovery.torn_bytes = facts.torn_bytes;
  recovery.outcome = outcome_of(facts, manifest, journal.string());
  manifest["outcome"] = acquisition::to_text(recovery.outcome);
  manifest["recovery"] = {{"utc", utc_now()},
                          {"rows", facts.rows},
                          {"torn_bytes", facts.torn_bytes},
                          {"end", facts.end ? *facts.end : Json(nullptr)}};
  manifest["files"] = nullptr;
  write_manifest(folder, manifest);
  return recovery;
}

bool is_torn_run(const std::filesystem::path& folder) {
  const Json manifest = manifest_of(folder);
  // However it ended: a disk that was full may have let nothing but the journal be written.
  const bool is_torn = !manifest.is_object() || manifest.value("outcome", "") == kInProgress ||
                       !std::filesystem::exists(folder / kRawFile);
  const std::filesystem::path journal = folder / kJournalFile;
  return is_torn && std::filesystem::exists(journal) && !is_being_written(journal);
}

std::vector<std::filesystem::path> find_torn_runs(const std::filesystem::path& runs_folder) {
  std::vector<std::filesystem::path> torn;
  for (const std::filesystem::path& folder : list_runs(runs_folder)) {
    if (is_torn_run(folder)) torn.push_back(folder);
  }
  return torn;
}

}  // namespace eha::record
