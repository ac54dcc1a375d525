// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/os/file_descriptor.hpp"

namespace eha::web {

/// Whether a text can be the name of a run's folder: 1 to 200 letters, digits, '-', '_', '.', the first no '.'.
[[nodiscard]] bool is_run_id(std::string_view text) noexcept;

/// Whether a run's file may be downloaded: run.json, raw.h5, NAME.csv, models/NAME.json and models/rejected/NAME.json,
/// NAME as a run's. Cost O(length).
[[nodiscard]] bool is_download(std::string_view path) noexcept;

/// A file of a run, open for reading.
struct RunFile {
  os::FileDescriptor descriptor;
  std::uint64_t size = 0;        ///< size when it was opened [bytes]
  std::int64_t modified_ns = 0;  ///< [ns since 1970]
  /// Returns a path with which other functions open the same file again, even if its name has come to mean another one.
  [[nodiscard]] std::filesystem::path path() const;
};

/// Read-only access to the run folders. Files are opened beneath the folder without following a link, so that no name
/// and no race leads outside. Thread-safe.
class RunStore {
 public:
  /// Sets the folder of the runs.
  void set_folder(std::filesystem::path folder);
  [[nodiscard]] std::filesystem::path folder() const;

  /// Opens a regular file of a run. @param path  from the run's folder
  /// @returns nothing if there is no readable one, or before set_folder()
  [[nodiscard]] std::optional<RunFile> open(std::string_view id, std::string_view path) const;

  /// Returns the text of a run's run.json.
  /// @throws DataError  there is no readable one, or it has more than kLargestManifest bytes
  [[nodiscard]] std::string manifest(std::string_view id) const;
  static constexpr std::uint64_t kLargestManifest = 16u << 20;  ///< [bytes]; two configuration files are far shorter

  /// Returns the name of the newest run with a journal, among the last ones one that was played for models if there is
  /// one; empty without any.
  [[nodiscard]] std::string newest() const;

  /// Lists the newest runs, newest first: id, name, started, outcome, grade, recommended, measured (what a run without
  /// models is for: the numbers of the valve, a move, a trial), reason, has_report, files; a
  /// run that cannot be read has id, outcome "unreadable" and error. Reads manifests again only if they changed.
  [[nodiscard]] nlohmann::ordered_json list(std::size_t most);

 private:
  /// Facts from run.json of one run, and the state of that file.
  struct Known {
    std::uint64_t size = 0;
    std::int64_t modified_ns = 0;
    nlohmann::ordered_json said;
  };

  [[nodiscard]] nlohmann::ordered_json describe(const std::string& id);

  mutable std::mutex mutex_;  ///< guards folder_
  std::filesystem::path folder_;
  std::mutex list_mutex_;  ///< guards known_
  std::map<std::string, Known> known_;
};

}  // namespace eha::web
