// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/os/file_descriptor.hpp"
#include "daemon/batch/record_list.hpp"

// The folder of a batch:
//
//   batch.json               the rules and the list of records; written first
//   batch.next.json          the longer list that is replacing batch.json
//   records/ID/result.json   the result of a record, its models in records/ID/models; appears complete or not at all
//   work/                    records in progress; renumbered/ has results whose ID the longer list changed
//   table.csv, table.json    written at the end
//   report.html              written at the end
//
// Every part of a batch (--shard) writes the same batch.json, so that parts may share a folder. A process keeps a
// shared lock on work/list.lock, or an exclusive one to change the list.

namespace eha::batch {

/// Rules that apply to every record.
struct Rules {
  std::string version;                ///< of eha
  std::vector<std::string> options;   ///< of `eha fit`
  std::vector<std::string> contents;  ///< SHA-256 of each option that names a file, otherwise empty

  bool operator==(const Rules&) const = default;
};

/// Rules of the given options of `eha fit`.
[[nodiscard]] Rules rules_of(std::vector<std::string> options);

struct Batch {
  Rules rules;
  std::vector<Record> records;
};

/// Result of a record.
struct Result {
  int exit_code = 0;           ///< of `eha fit`
  std::string message;         ///< its last messages
  nlohmann::ordered_json fit;  ///< its document (schema eha-fit/1); null without one
  double seconds = 0.0;        ///< wall time
  std::string host;
};

/// Whether models were fitted, accepted or not.
[[nodiscard]] inline bool is_judged(const Result& result) { return result.fit.is_object(); }

/// One of `count` equal parts of a list: the records whose position is `number` modulo `count`.
struct Shard {
  std::size_t number = 1;  ///< from 1
  std::size_t count = 1;
};

/// A batch's folder. Not thread-safe; several processes may use one folder, each for a shard of its own.
class BatchFolder {
 public:
  /// Creates the folder and batch.json, or continues the batch in it. A list that holds all its records and new ones
  /// replaces the old list. Results are kept and get their IDs of the new list, even after a kill in between.
  /// @throws UsageError  the folder holds another batch: the message names the difference; or the list is longer and
  ///                     another process works on the batch
  /// @throws IoError, PermissionError
  BatchFolder(std::filesystem::path path, Batch batch);
  /// Opens an existing batch. @throws DataError  no batch, or damaged; IoError, PermissionError
  explicit BatchFolder(std::filesystem::path path);

  [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
  [[nodiscard]] const Batch& batch() const noexcept { return batch_; }

  /// Takes a shard for this process and removes its remains of a killed process from work/.
  /// @throws UsageError  another process works on it
  void claim(const Shard& shard);

  /// The records of a shard without a result.
  [[nodiscard]] std::vector<Record> open_records(const Shard& shard) const;

  /// A new, empty folder to fit a record in. Call after claim().
  [[nodiscard]] std::filesystem::path work_folder(const Record& record) const;

  /// Writes result.json into the record's work folder and moves that folder to records/.
  void publish(const Record& record, const Result& result) const;

  /// The result of a record; none without one. @throws DataError  damaged; IoError, PermissionError
  [[nodiscard]] std::optional<Result> result(const Record& record) const;

  /// Copies the results that this batch lacks from a part in another folder. @throws UsageError  it is another batch
  void take_from(const BatchFolder& part) const;

 private:
  /// Makes batch_ the folder's list, if it is not, and prevents others from changing it.
  void hold_list();
  /// Whether batch_ is the folder's list. @throws UsageError  the list is of another batch
  [[nodiscard]] bool has_list() const;
  /// Replaces the folder's list by batch_, and gives each result its ID of batch_.
  void replace_list() const;
  /// Whether a process was killed while it replaced the list.
  [[nodiscard]] bool is_replacing() const;
  /// Completes that replacement.
  void finish_replacing() const;

  std::filesystem::path path_;
  Batch batch_;
  std::filesystem::path work_;
  os::FileDescriptor list_lock_;
  os::FileDescriptor lock_;
};

}  // namespace eha::batch
