// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/retention.hpp"

#include <spdlog/spdlog.h>

#include <system_error>

#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;

std::uint64_t size_of(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && !entry.is_symlink()) bytes += entry.file_size();
  }
  return bytes;
}

/// Over, and without an accepted model.
bool may_go(const fs::path& folder) {
  const nlohmann::ordered_json manifest = record::read_manifest(folder);
  if (manifest.value("outcome", "") == record::kInProgress) return false;
  const auto identification = manifest.find("identification");
  if (identification == manifest.end() || !identification->is_object()) return true;
  const auto accepted = identification->find("accepted");
  return accepted == identification->end() || *accepted != true;
}

struct Candidate {
  fs::path folder;
  std::uint64_t bytes = 0;
};

}  // namespace

Retention keep_within_budget(const fs::path& runs_folder, std::uint64_t budget_bytes,
                             const std::set<std::string>& kept) {
  Retention retention;
  std::vector<Candidate> candidates;
  for (const fs::path& folder : record::list_runs(runs_folder)) {
    try {
      const std::uint64_t bytes = size_of(folder);
      retention.bytes += bytes;
      if (!kept.contains(folder.filename().string()) && may_go(folder)) candidates.push_back({folder, bytes});
    } catch (const std::exception& error) {
      spdlog::warn("{}: left as it is: {}", folder.string(), error.what());
    }
  }
  for (const Candidate& candidate : candidates) {
    if (retention.bytes <= budget_bytes) break;
    std::error_code error;
    fs::remove_all(candidate.folder, error);
    if (error) {
      spdlog::warn("{}: cannot be removed: {}", candidate.folder.string(), error.message());
      continue;
    }
    retention.bytes -= candidate.bytes;
    retention.removed.push_back({candidate.folder.filename().string(), candidate.bytes});
  }
  retention.over_budget = retention.bytes > budget_bytes;
  return retention;
}

}  // namespace eha::service
