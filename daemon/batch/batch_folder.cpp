// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/batch_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <chrono>
#include <map>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "core/error.hpp"
#include "core/json_text.hpp"
#include "core/os/files.hpp"
#include "daemon/record/one_line_texts.hpp"
#include "daemon/record/own_file.hpp"
#include "daemon/record/sha256.hpp"

namespace eha::batch {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kManifestFile = "batch.json";
constexpr const char* kNextManifestFile = "batch.next.json";
constexpr const char* kRecords = "records";
constexpr const char* kWork = "work";
constexpr const char* kRenumbered = "renumbered";
constexpr const char* kListLock = "list.lock";
constexpr const char* kResultFile = "result.json";
constexpr const char* kSchema = "eha-batch/1";
constexpr const char* kResultSchema = "eha-batch-record/1";
// Others replace the list in much less time, and parts that start together take turns.
constexpr auto kPatience = std::chrono::seconds(3);
constexpr auto kTurn = std::chrono::milliseconds(20);

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
    Json document = parse_json_text<Json>(os::read_regular_file(path));
    if (document.is_discarded()) throw DataError(fmt::format("{}: damaged: no JSON", path.string()));
    record::make_one_line(document);
    if (document.at("schema") != schema) throw DataError(fmt::format("{}: not of schema {}", path.string(), schema));
    return read(document);
  } catch (const nlohmann::json::exception& error) {
    throw DataError(fmt::format("{}: damaged: {}", path.string(), error.what()));
  }
}

/// A list may be a stranger's, and an ID becomes the name of a folder. @throws DataError
void require_folder_name(const fs::path& list, const std::string& id) {
  const bool is_name =
      !id.empty() && id.front() != '.' && id.find_first_of(std::string_view("/\0", 2)) == std::string::npos;
  if (!is_name) throw DataError(fmt::format("{}: \"{}\" is no name of a record's folder", list.string(), id));
}

Batch read_batch(const fs::path& path) {
  return parsed(path, kSchema, [&](const Json& document) {
    Batch batch;
    batch.rules = {document.at("version"), document.at("options"), document.at("option_sha256")};
    for (const Json& record : document.at("records")) {
      batch.records.push_back({record.at("id"), record.at("source"), record.at("sha256")});
      require_folder_name(path, batch.records.back().id);
    }
    return batch;
  });
}

/// Files are moved to and from the folders of a batch: none of them may lead elsewhere. @throws DataError
void require_no_links(const fs::path& batch) {
  for (const fs::path& name : {fs::path(kRecords), fs::path(kWork), fs::path(kWork) / kRenumbered}) {
    record::require_no_link(batch / name);
  }
}

os::FileDescriptor open_lock(const fs::path& path) { return os::open_file(path, O_RDWR | O_CREAT | O_NOFOLLOW); }

/// The difference of two batches' rules in one sentence; empty for none.
std::string difference(const Rules& there, const Rules& here) {
  if (there.version != here.version) {
    return fmt::format("it was begun by eha {}, this is {}", there.version, here.version);
  }
  if (there.options != here.options) {
    return fmt::format("its options of `eha fit` were \"{}\", now they are \"{}\"", fmt::join(there.options, " "),
                       fmt::join(here.options, " "));
  }
  if (there.contents != here.contents) return "a file that its options name has changed";
  return {};
}

/// The same of whole batches.
std::string difference(const Batch& there, const Batch& here) {
  if (std::string rules = difference(there.rules, here.rules); !rules.empty()) return rules;
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

/// Records by their source.
std::map<std::string_view, const Record*> by_source(const std::vector<Record>& records) {
  std::map<std::string_view, const Record*> found;
  for (const Record& record : records) found.emplace(record.source, &record);
  return found;
}

/// Returns the reason for which a batch cannot replace the one in the folder (it must contain all of its records);
/// empty if it can.
std::string obstacle(const Batch& there, const Batch& here) {
  if (std::string rules = difference(there.rules, here.rules); !rules.empty()) return rules;
  const auto named = by_source(here.records);
  for (const Record& record : there.records) {
    const auto found = named.find(record.source);
    if (found == named.end()) {
      return fmt::format("it has {} records, now there are {}, without {}; records are added by naming all of them",
                         there.records.size(), here.records.size(), record.source);
    }
    if (found->second->sha256 != record.sha256) return fmt::format("{} has changed", record.source);
  }
  return {};
}

void move(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) os::throw_system_error("move", from, error.value());
}

/// Calls flock(2). @returns false  another process has the lock, and the operation does not wait
bool lock(const os::FileDescriptor& file, int operation, const fs::path& path) {
  while (flock(file.get(), operation) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno != EINTR) os::throw_system_error("lock", path, errno);
  }
  return true;
}

}  // namespace

Rules rules_of(std::vector<std::string> options) {
  Rules rules{.version = EHA_VERSION, .options = std::move(options), .contents = {}};
  for (const std::string& word : rules.options) {
    // Returns FILE of "--experiment=FILE".
    const std::string value = word.starts_with("--") ? word.substr(word.find('=') + 1) : word;
    std::error_code ignored;
    rules.contents.push_back(fs::is_regular_file(value, ignored) ? record::sha256_of_file(value) : std::string());
  }
  return rules;
}

BatchFolder::BatchFolder(fs::path path, Batch batch) : path_(std::move(path)), batch_(std::move(batch)) {
  require_no_links(path_);
  os::create_folders(path_ / kRecords);
  hold_list();
}

BatchFolder::BatchFolder(fs::path path) : path_(std::move(path)) {
  if (!fs::exists(path_ / kManifestFile)) {
    throw DataError(fmt::format("{}: no batch: it has no {}", path_.string(), kManifestFile));
  }
  require_no_links(path_);
  if (is_replacing()) {
    batch_ = read_batch(fs::exists(path_ / kNextManifestFile) ? path_ / kNextManifestFile : path_ / kManifestFile);
    hold_list();
  }
  batch_ = read_batch(path_ / kManifestFile);
}

void BatchFolder::hold_list() {
  os::create_folders(path_ / kWork);
  const fs::path file = path_ / kWork / kListLock;
  list_lock_ = open_lock(file);
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    lock(list_lock_, LOCK_SH, file);
    if (has_list()) return;
    // Two processes that both kept the shared lock would wait for each other.
    lock(list_lock_, LOCK_UN, file);
    if (lock(list_lock_, LOCK_EX | LOCK_NB, file)) {
      finish_replacing();
      if (!has_list()) replace_list();
    } else if (std::chrono::steady_clock::now() > end) {
      throw UsageError(
          fmt::format("{}: another process works on this batch; name more records when it has ended", path_.string()));
    } else {
      std::this_thread::sleep_for(kTurn);
    }
  }
}

bool BatchFolder::has_list() const {
  if (is_replacing() || !fs::exists(path_ / kManifestFile)) return false;
  const Batch there = read_batch(path_ / kManifestFile);
  if (const std::string other = obstacle(there, batch_); !other.empty()) {
    throw UsageError(fmt::format("{} holds another batch: {}; choose another folder with -o", path_.string(), other));
  }
  return there.records == batch_.records;
}

void BatchFolder::replace_list() const {
  const bool is_new = !fs::exists(path_ / kManifestFile);
  os::write_file_atomically(path_ / (is_new ? kManifestFile : kNextManifestFile), text_of(batch_));
  finish_replacing();
}

bool BatchFolder::is_replacing() const {
  return fs::exists(path_ / kNextManifestFile) || fs::exists(path_ / kWork / kRenumbered);
}

void BatchFolder::finish_replacing() const {
  const fs::path aside = path_ / kWork / kRenumbered;
  if (fs::exists(path_ / kNextManifestFile)) {
    // No result has an ID of the new list yet, so an existing result has one of the old list.
    const Batch next = read_batch(path_ / kNextManifestFile);
    const auto named = by_source(next.records);
    os::create_folders(aside);
    for (const Record& record : read_batch(path_ / kManifestFile).records) {
      const auto found = named.find(record.source);
      if (found == named.end()) {
        throw DataError(fmt::format("{}: lacks {}", (path_ / kNextManifestFile).string(), record.source));
      }
      const std::string& id = found->second->id;
      const fs::path from = path_ / kRecords / record.id;
      if (id != record.id && fs::exists(from)) move(from, aside / id);
    }
    move(path_ / kNextManifestFile, path_ / kManifestFile);
  }
  if (!fs::exists(aside)) return;
  std::vector<fs::path> results;
  for (const fs::directory_entry& result : fs::directory_iterator(aside)) results.push_back(result.path());
  for (const fs::path& result : results) move(result, path_ / kRecords / result.filename());
  fs::remove(aside);
}

namespace {

/// Removes what a batch that was killed has left. Its last fit ends with it, and may write or remove there meanwhile.
/// @throws IoError
void remove_left_over(const fs::path& folder) {
  constexpr int kTries = 40;
  constexpr std::chrono::milliseconds kBetween{50};
  std::error_code error;
  for (int k = 0; k < kTries; ++k) {
    fs::remove_all(folder, error);
    if (!error) return;
    const bool may_pass = error == std::errc::no_such_file_or_directory || error == std::errc::directory_not_empty;
    if (!may_pass) break;
    std::this_thread::sleep_for(kBetween);
  }
  os::throw_system_error("remove", folder, error.value());
}

}  // namespace

void BatchFolder::claim(const Shard& shard) {
  const std::string name = fmt::format("{}-of-{}", shard.number, shard.count);
  work_ = path_ / kWork / name;
  os::create_folders(path_ / kWork);
  lock_ = open_lock(path_ / kWork / (name + ".lock"));
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    throw UsageError(fmt::format("{}: another process works on part {} of {} of this batch", path_.string(),
                                 shard.number, shard.count));
  }
  remove_left_over(work_);
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
  // An overlapping part may have been faster.
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
  move(folder, path_ / kRecords / record.id);
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
    std::error_code error;
    if (!fs::is_directory(fs::symlink_status(from, error)) || fs::exists(to)) continue;
    fs::remove_all(beside, error);
    if (!error) fs::create_directories(beside.parent_path(), error);
    if (!error) fs::copy(from, beside, fs::copy_options::recursive | fs::copy_options::skip_symlinks, error);
    if (!error) fs::rename(beside, to, error);
    if (error) os::throw_system_error("copy", from, error.value());
  }
}

}  // namespace eha::batch
