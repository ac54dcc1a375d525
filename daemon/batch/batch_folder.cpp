// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/batch_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kManifestFile = "batch.json";
constexpr const char* kRecords = "records";
constexpr const char* kWork = "work";
constexpr const char* kResultFile = "result.json";
constexpr const char* kSchema = "eha-batch/1";
constexpr const char* kResultSchema = "eha-batch-record/1";

std::string text_of(const Batch& batch) {
  Json records = Json::array();
  for (const Record& record : batch.records) {
    records.push_back({{"id", record.id}, {"source", record.source}, {"sha256", record.sha256}});
  }
  const Json document{{"schema", kSchema},
                      {"version", batch.rules.version},
                      {"options", batch.rules.options},
                      {"option_sha256", batch.rules.contents},
                      {"records", std::move(records)}};
  return document.dump(2) + "\n";
}

/// @throws DataError  not a document of this schema
template <class Read>
auto parsed(const fs::path& path, const char* schema, const Read& read) {
  try {
    const Json document = Json::parse(os::read_file(path));
    if (document.at("schema") != schema) throw DataError(fmt::format("{}: not of schema {}", path.string(), schema));
    return read(document);
  } catch (const nlohmann::json::exception& error) {
    throw DataError(fmt::format("{}: damaged: {}", path.string(), error.what()));
  }
}

Batch read_batch(const fs::path& path) {
  return parsed(path, kSchema, [](const Json& document) {
    Batch batch;
    batch.rules = {document.at("version"), document.at("options"), document.at("option_sha256")};
    for (const Json& record : document.at("records")) {
      batch.records.push_back({record.at("id"), record.at("source"), record.at("sha256")});
    }
    return batch;
  });
}

/// The difference of two batches in one sentence; empty for none.
std::string difference(const Batch& there, const Batch& here) {
  if (there.rules.version != here.rules.version) {
    return fmt::format("it was begun by eha {}, this is {}", there.rules.version, here.rules.version);
  }
  if (there.rules.options != here.rules.options) {
    return fmt::format("its options of `eha fit` were \"{}\", now they are \"{}\"", fmt::join(there.rules.options, " "),
                       fmt::join(here.rules.options, " "));
  }
  if (there.rules.contents != here.rules.contents) return "a file that its options name has changed";
  if (there.records.size() != here.records.size()) {
    return fmt::format("it has {} records, now there are {}", there.records.size(), here.records.size());
  }
  for (std::size_t i = 0; i < here.records.size(); ++i) {
    if (there.records[i].source != here.records[i].source) {
      return fmt::format("its record {} is {}, now it is {}", i + 1, there.records[i].source, here.records[i].source);
    }
    if (there.records[i] != here.records[i]) return fmt::format("{} has changed", here.records[i].source);
  }
  return {};
}

}  // namespace

Rules rules_of(std::vector<std::string> options) {
  Rules rules{.version = EHA_VERSION, .options = std::move(options), .contents = {}};
  for (const std::string& word : rules.options) {
    // Of "--experiment=FILE" the file.
    const std::string value = word.starts_with("--") ? word.substr(word.find('=') + 1) : word;
    std::error_code ignored;
    rules.contents.push_back(fs::is_regular_file(value, ignored) ? record::sha256_of_file(value) : std::string());
  }
  return rules;
}

BatchFolder::BatchFolder(fs::path path, Batch batch) : path_(std::move(path)), batch_(std::move(batch)) {
  os::create_folders(path_ / kRecords);
  const fs::path manifest = path_ / kManifestFile;
  if (!fs::exists(manifest)) {
    os::write_file_atomically(manifest, text_of(batch_));
    return;
  }
  const std::string other = difference(read_batch(manifest), batch_);
  if (other.empty()) return;
  throw UsageError(fmt::format("{} holds another batch: {}; choose another folder with -o", path_.string(), other));
}

BatchFolder::BatchFolder(fs::path path) : path_(std::move(path)) {
  if (!fs::exists(path_ / kManifestFile)) {
    throw DataError(fmt::format("{}: no batch: it has no {}", path_.string(), kManifestFile));
  }
  batch_ = read_batch(path_ / kManifestFile);
}

void BatchFolder::claim(const Shard& shard) {
  const std::string name = fmt::format("{}-of-{}", shard.number, shard.count);
  work_ = path_ / kWork / name;
  os::create_folders(path_ / kWork);
  lock_ = os::open_file(path_ / kWork / (name + ".lock"), O_RDWR | O_CREAT);
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    throw UsageError(fmt::format("{}: another process works on part {} of {} of this batch", path_.string(),
                                 shard.number, shard.count));
  }
  std::error_code error;
  fs::remove_all(work_, error);
  if (error) os::throw_system_error("remove", work_, error.value());
}

std::vector<Record> BatchFolder::open_records(const Shard& shard) const {
  std::vector<Record> open;
  for (std::size_t i = shard.number - 1; i < batch_.records.size(); i += shard.count) {
    if (!fs::exists(path_ / kRecords / batch_.records[i].id)) open.push_back(batch_.records[i]);
  }
  return open;
}

fs::path BatchFolder::work_folder(const Record& record) const {
  fs::path folder = work_ / record.id;
  os::create_folders(folder);
  return folder;
}

void BatchFolder::publish(const Record& record, const Result& result) const {
  // An overlapping part may have been quicker.
  if (fs::exists(path_ / kRecords / record.id)) {
    fs::remove_all(work_ / record.id);
    return;
  }
  const Json document{{"schema", kResultSchema},       {"source", record.source},   {"sha256", record.sha256},
                      {"exit_code", result.exit_code}, {"message", result.message}, {"fit", result.fit},
                      {"seconds", result.seconds},     {"host", result.host}};
  const fs::path folder = work_ / record.id;
  // A message may be cut within a character.
  os::write_file_atomically(folder / kResultFile, document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  std::error_code error;
  fs::rename(folder, path_ / kRecords / record.id, error);
  if (error) os::throw_system_error("move", folder, error.value());
}

std::optional<Result> BatchFolder::result(const Record& record) const {
  const fs::path file = path_ / kRecords / record.id / kResultFile;
  if (!fs::exists(file)) return {};
  return parsed(file, kResultSchema, [](const Json& document) {
    return Result{document.at("exit_code"), document.at("message"), document.at("fit"), document.at("seconds"),
                  document.at("host")};
  });
}

void BatchFolder::take_from(const BatchFolder& part) const {
  if (const std::string other = difference(part.batch_, batch_); !other.empty()) {
    throw UsageError(
        fmt::format("{} and {} are parts of different batches: {}", path_.string(), part.path_.string(), other));
  }
  const fs::path beside = path_ / kWork / "merge";
  for (const Record& record : batch_.records) {
    const fs::path from = part.path_ / kRecords / record.id;
    const fs::path to = path_ / kRecords / record.id;
    if (!fs::exists(from) || fs::exists(to)) continue;
    std::error_code error;
    fs::remove_all(beside, error);
    if (!error) fs::create_directories(beside.parent_path(), error);
    if (!error) fs::copy(from, beside, fs::copy_options::recursive, error);
    if (!error) fs::rename(beside, to, error);
    if (error) os::throw_system_error("copy", from, error.value());
  }
}

}  // namespace eha::batch
