// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/record_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "core/terminal_text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kListEnding = ".list";
constexpr std::array<std::string_view, 10> kRecordEndings{".csv", ".txt",  ".tsv", ".dat", ".lvm",
                                                          ".asc", ".xlsx", ".mat", ".h5",  ".hdf5"};
constexpr std::size_t kLongestName = 40;
/// Of a record's file, which is summed: more than all rows that are read of one take.
constexpr std::uintmax_t kMostBytes = std::uintmax_t{4} << 30U;
constexpr const char* kNotForModels =
    "a run without an experiment for models: it placed the rod, measured the valve or followed a reference";

bool is_record_file(const fs::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kRecordEndings.begin(), kRecordEndings.end(), ending) != kRecordEndings.end();
}

bool is_for_models(const fs::path& run) {
  try {
    return record::purpose_of(record::read_manifest(run)) == record::Purpose::models;
  } catch (const Error&) {
    return true;  // unreadable files are listed with the reason
  }
}

/// Why the manifest could not name a path, or its name could imitate messages of the program; empty for plain text.
std::string why_no_text(const fs::path& path) {
  if (one_line(path.string()) != path.string()) {
    return "its name holds the end of a line or another character that controls a terminal; rename it";
  }
  try {
    static_cast<void>(nlohmann::json(path.string()).dump());
  } catch (const nlohmann::json::exception&) {
    return "its name is not UTF-8 text; rename it, for instance with convmv";
  }
  return {};
}

/// Why an item of a folder is no record; empty for a record.
std::string why_skipped(const fs::directory_entry& item) {
  std::error_code ignored;
  if (item.is_directory(ignored)) {
    if (item.is_symlink()) return "a link to a folder; name the folder to take it";
    if (!record::is_run_folder(item.path())) return "a folder within the folder; name it to take its records";
    return is_for_models(item.path()) ? "" : kNotForModels;
  }
  if (item.is_symlink() && !item.exists(ignored)) return "a link to nothing";
  if (!item.is_regular_file(ignored)) return "no file";
  return is_record_file(item.path()) ? "" : fmt::format("no ending of a record ({})", fmt::join(kRecordEndings, ", "));
}

/// When a run began; empty for what is no run or does not say it.
std::string start_of(const fs::path& record) {
  if (!record::is_run_folder(record)) return {};
  try {
    return text_at(record::read_manifest(record).other, "/utc_start");
  } catch (const Error&) {  // an unreadable run is listed with the reason
    return {};
  }
}

/// Sorts runs by when they began; by their names where one does not say it.
void sort_by_time(std::vector<fs::path>& records) {
  std::vector<std::pair<std::string, fs::path>> started;
  for (fs::path& record : records) started.emplace_back(start_of(record), std::move(record));
  const bool all_say = std::none_of(started.begin(), started.end(), [](const auto& one) { return one.first.empty(); });
  std::sort(started.begin(), started.end(),
            [&](const auto& a, const auto& b) { return all_say ? a < b : a.second < b.second; });
  for (std::size_t i = 0; i < records.size(); ++i) records[i] = std::move(started[i].second);
}

/// The file that tells whether a record has changed.
fs::path summed_file(const fs::path& source) {
  std::error_code ignored;
  return fs::is_directory(source, ignored) ? source / record::kManifestFile : source;
}

/// Why a record is neither summed nor fitted; empty if it is, or if there is none.
std::string why_not_read(const fs::path& source) {
  std::error_code ignored;
  const fs::path file = summed_file(source);
  const fs::file_status there = fs::status(file, ignored);
  if (!fs::exists(there)) return {};
  if (!fs::is_regular_file(there)) return "a pipe or a device, which may have no end; save it to a file";
  const std::uintmax_t bytes = fs::file_size(file, ignored);
  if (ignored || bytes <= kMostBytes) return {};
  return fmt::format("a file of {} GiB, more than {}; make a record of a part by eha import", bytes >> 30U,
                     kMostBytes >> 30U);
}

std::vector<fs::path> records_in(const fs::path& folder, std::vector<Skipped>& skipped) {
  std::vector<fs::path> found;
  std::vector<Skipped> others;
  std::error_code error;
  for (fs::directory_iterator item(folder, error), end; !error && item != end; item.increment(error)) {
    // The link of a runs folder to one of its runs.
    if (item->is_symlink() && item->path().filename() == record::kLatestLink) continue;
    std::string why = why_skipped(*item);
    if (why.empty()) why = why_no_text(item->path());
    if (why.empty()) {
      found.push_back(item->path());
    } else {
      others.push_back({item->path().string(), std::move(why)});
    }
  }
  if (error) os::throw_system_error("read", folder, error.value());
  sort_by_time(found);
  std::sort(others.begin(), others.end(), [](const Skipped& a, const Skipped& b) { return a.source < b.source; });
  skipped.insert(skipped.end(), others.begin(), others.end());
  return found;
}

std::vector<fs::path> records_listed_in(const fs::path& list) {
  std::vector<fs::path> found;
  std::istringstream lines(os::read_regular_file(list));
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    found.push_back((list.parent_path() / line).lexically_normal());
  }
  return found;
}

std::vector<fs::path> records_named_by(const fs::path& source, std::vector<Skipped>& skipped) {
  if (source.extension() == kListEnding) return records_listed_in(source);
  std::error_code ignored;
  if (!fs::is_directory(source, ignored)) return {source};
  if (!record::is_run_folder(source)) return records_in(source, skipped);
  if (is_for_models(source)) return {source};
  skipped.push_back({source.string(), kNotForModels});
  return {};
}

/// The name of a record: of a run that a link names (latest) the run's own.
fs::path name_of(const fs::path& source) {
  std::error_code error;
  const fs::path folder = fs::is_directory(source, error) ? fs::canonical(source, error) : fs::path();
  if (!error && !folder.empty()) return folder.filename();
  return source.has_filename() ? source.filename() : source.parent_path().filename();
}

/// Keeps letters, digits, '-', '_' and '.' of a record's name.
std::string plain_name(const fs::path& source) {
  const fs::path name = name_of(source);
  std::string plain = name.stem().string().substr(0, kLongestName);
  for (char& c : plain) {
    const bool stays = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || c == '.';
    if (!stays) c = '-';
  }
  return plain;
}

std::string content_of(const fs::path& source) {
  try {
    return record::sha256_of_file(summed_file(source));
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

FoundRecords records_of(const std::vector<std::string>& sources) {
  FoundRecords found;
  std::vector<Record>& records = found.records;
  std::set<fs::path> seen;
  std::error_code ignored;
  if (sources.size() == 1 && !fs::exists(sources.front(), ignored)) {
    throw UsageError(sources.front() + ": no such file or folder");
  }
  for (const std::string& source : sources) {
    for (const fs::path& path : records_named_by(source, found.skipped)) {
      if (!seen.insert(path.lexically_normal()).second) continue;
      if (const std::string why = why_no_text(path); !why.empty()) {
        throw UsageError(fmt::format("{}: {}", one_line(path.string()), why));
      }
      if (std::string why = why_not_read(path); !why.empty()) {
        found.skipped.push_back({path.string(), std::move(why)});
        continue;
      }
      records.push_back(
          {fmt::format("{:04}-{}", records.size() + 1, plain_name(path)), path.string(), content_of(path)});
    }
  }
  if (records.empty()) {
    const bool are_runs = std::all_of(found.skipped.begin(), found.skipped.end(),
                                      [](const Skipped& one) { return one.why == kNotForModels; });
    if (!found.skipped.empty() && (are_runs || found.skipped.front().source == sources.front())) {
      throw UsageError(fmt::format("{}: no record: {} is {}", fmt::join(sources, ", "), found.skipped.front().source,
                                   found.skipped.front().why));
    }
    throw UsageError(fmt::format("{}: no record: no run folder and no file ending in {}", fmt::join(sources, ", "),
                                 fmt::join(kRecordEndings, ", ")));
  }
  return found;
}

}  // namespace eha::batch
