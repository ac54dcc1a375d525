// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/run_index.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/os/users.hpp"
#include "core/text.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_summary.hpp"

namespace eha::service {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kBytesPerMB = 1e6;
constexpr const char* kUnreadable = "unreadable";

std::uint64_t size_of(const fs::path& folder) {
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file() && !entry.is_symlink()) bytes += entry.file_size();
  }
  return bytes;
}

/// Copies outcome, verdict and size from the folder; a run whose folder cannot be read is not removed.
void read_folder(const fs::path& folder, IndexedRun& run) {
  try {
    run.bytes = size_of(folder);
    const record::Manifest manifest = record::read_manifest(folder);
    run.outcome = record::outcome_text(manifest);
    run.accepted = manifest.identification && manifest.identification->accepted;
  } catch (const std::exception& error) {
    run.outcome = kUnreadable;
    spdlog::warn("{}: cannot be read, so it is kept: {}", folder.string(), error.what());
  }
}

std::string line_of(const std::string& name, const IndexedRun& run) {
  return Json{{"run", name},
              {"sequence", run.sequence},
              {"owner", run.owner},
              {"outcome", run.outcome},
              {"accepted", run.accepted},
              {"acknowledged", run.acknowledged},
              {"bytes", run.bytes}}
             .dump(-1, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace

bool IndexedRun::is_incident() const {
  return !acquisition::is_whole(outcome) && outcome != record::kInProgress && outcome != kUnreadable;
}

bool IndexedRun::may_go() const {
  if (accepted || outcome == record::kInProgress || outcome == kUnreadable) return false;
  return !is_incident() || acknowledged;
}

RunIndex::RunIndex(fs::path file, fs::path runs_folder) : file_(std::move(file)), folder_(std::move(runs_folder)) {
  load();
  compare_with_folder();
  std::string text;
  for (const auto& [name, run] : runs_) text += line_of(name, run);
  os::write_file_atomically(file_, text);
}

void RunIndex::load() {
  std::error_code error;
  if (!fs::exists(file_, error)) return;
  std::istringstream lines(os::read_file(file_));
  for (std::string line; std::getline(lines, line);) {
    // A line that was cut off when the program died is replaced by the facts of the folder.
    const Json json = Json::parse(line, nullptr, false);
    try {
      const std::string name = json.at("run");
      if (json.value("removed", false)) {
        forget(name);
        continue;
      }
      add(name, {json.at("sequence"), json.at("owner"), json.at("outcome"), json.at("accepted"),
                 json.at("acknowledged"), json.at("bytes")});
    } catch (const Json::exception&) {
      continue;
    }
  }
}

void RunIndex::add(const std::string& run, IndexedRun facts) {
  forget(run);
  bytes_ += facts.bytes;
  last_sequence_ = std::max(last_sequence_, facts.sequence);
  runs_[run] = std::move(facts);
}

void RunIndex::forget(const std::string& run) {
  const auto found = runs_.find(run);
  if (found == runs_.end()) return;
  bytes_ -= found->second.bytes;
  runs_.erase(found);
}

void RunIndex::append(const std::string& run) const {
  const auto found = runs_.find(run);
  const std::string line =
      found == runs_.end() ? Json{{"run", run}, {"removed", true}}.dump() + "\n" : line_of(run, found->second);
  const os::FileDescriptor file = os::open_file(file_, O_WRONLY | O_CREAT | O_APPEND, 0640);
  if (write(file.get(), line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
    os::throw_system_error("write", file_, errno);
  }
}

void RunIndex::compare_with_folder() {
  std::set<std::string> there;
  for (const fs::path& folder : record::list_runs(folder_)) {
    const std::string name = folder.filename().string();
    there.insert(name);
    const auto found = runs_.find(name);
    const bool is_over = found != runs_.end() && found->second.outcome != record::kInProgress;
    if (is_over) continue;
    IndexedRun run;
    if (found != runs_.end()) run = found->second;
    if (run.sequence == 0) run.sequence = ++last_sequence_;
    read_folder(folder, run);
    add(name, std::move(run));
  }
  std::vector<std::string> gone;
  for (const auto& [name, run] : runs_) {
    if (!there.contains(name)) gone.push_back(name);
  }
  for (const std::string& name : gone) forget(name);
  mend_latest();
}

IndexedRun& RunIndex::known(const std::string& run) {
  const auto found = runs_.find(run);
  if (found == runs_.end()) {
    throw UsageError(fmt::format("{}: the service has no such run; see eha runs list", shortened(run, 80)));
  }
  return found->second;
}

void RunIndex::begin(const std::string& run, uid_t owner) {
  IndexedRun facts;
  facts.sequence = last_sequence_ + 1;
  facts.owner = owner;
  facts.outcome = record::kInProgress;
  add(run, std::move(facts));
  append(run);
}

void RunIndex::update(const std::string& run) {
  std::error_code error;
  if (!fs::exists(folder_ / run, error)) {
    forget(run);
  } else {
    const auto found = runs_.find(run);
    IndexedRun facts = found != runs_.end() ? found->second : IndexedRun{};
    if (facts.sequence == 0) facts.sequence = last_sequence_ + 1;
    read_folder(folder_ / run, facts);
    add(run, std::move(facts));
  }
  append(run);
  mend_latest();
}

/// Lets a link `latest` that leads to nothing name the newest run that may be it, or removes it.
void RunIndex::mend_latest() const noexcept {
  try {
    const fs::path link = folder_ / record::kLatestLink;
    if (!fs::is_symlink(link) || fs::exists(link)) return;
    std::vector<std::pair<std::int64_t, std::string>> accepted;
    for (const auto& [name, run] : runs_) {
      if (run.accepted && fs::exists(folder_ / name)) accepted.emplace_back(run.sequence, name);
    }
    std::sort(accepted.rbegin(), accepted.rend());
    for (const auto& [sequence, name] : accepted) {
      if (!record::reason_against_latest(record::read_manifest(folder_ / name)).empty()) continue;
      record::publish_latest(record::OpenRun(folder_ / name));
      spdlog::info("latest is {}: the run that it was is gone", name);
      return;
    }
    fs::remove(link);
    spdlog::info("latest is removed: no run with an accepted model is left");
  } catch (const std::exception& error) {
    spdlog::warn("{}: leads to no run: {}", (folder_ / record::kLatestLink).string(), error.what());
  }
}

void RunIndex::acknowledge(const std::string& run) {
  IndexedRun& facts = known(run);
  if (!facts.is_incident()) {
    throw UsageError(fmt::format("{}: {}; there is no incident to acknowledge", run, facts.outcome));
  }
  facts.acknowledged = true;
  append(run);
}

std::uint64_t RunIndex::remove(const std::string& run, uid_t by) {
  const IndexedRun& facts = known(run);
  if (by != 0 && by != facts.owner) {
    throw PermissionError(
        fmt::format("{}: of {}; only its owner and root may remove it", run, os::local_user_text(facts.owner)));
  }
  if (facts.outcome == record::kInProgress) throw UsageError(fmt::format("{}: the run is on", run));
  const std::uint64_t bytes = facts.bytes;
  std::error_code error;
  fs::remove_all(folder_ / run, error);
  if (error) os::throw_system_error("remove", folder_ / run, error.value());
  forget(run);
  append(run);
  mend_latest();
  return bytes;
}

std::vector<std::string> RunIndex::removable(const std::set<std::string>& in_use) const {
  std::vector<std::pair<std::int64_t, std::string>> ordered;
  for (const auto& [name, run] : runs_) ordered.emplace_back(run.sequence, name);
  std::sort(ordered.begin(), ordered.end());
  ordered.resize(ordered.size() - std::min(ordered.size(), kNewestKept));
  std::vector<std::string> names;
  for (auto& [sequence, name] : ordered) {
    if (!in_use.contains(name) && runs_.at(name).may_go()) names.push_back(std::move(name));
  }
  return names;
}

void RunIndex::remove_until(std::uint64_t budget_bytes, const std::set<std::string>& in_use, Retention& retention) {
  for (const std::string& name : removable(in_use)) {
    if (bytes_ <= budget_bytes) return;
    // A user may have fitted it, or removed it, without the service.
    update(name);
    const auto found = runs_.find(name);
    if (found == runs_.end() || !found->second.may_go()) continue;
    try {
      retention.removed.push_back({name, remove(name, 0)});
    } catch (const Error& error) {
      spdlog::warn("{}", error.what());
    }
  }
}

Retention RunIndex::keep_within(std::uint64_t budget_bytes, const std::set<std::string>& in_use) {
  Retention retention;
  if (bytes_ > budget_bytes) remove_until(budget_bytes, in_use, retention);
  if (bytes_ > budget_bytes) {
    // A user may have removed runs to make room.
    compare_with_folder();
    remove_until(budget_bytes, in_use, retention);
  }
  retention.bytes = bytes_;
  if (bytes_ > budget_bytes) retention.refusal = refusal(budget_bytes);
  return retention;
}

std::string RunIndex::refusal(std::uint64_t budget_bytes) const {
  std::uint64_t accepted_bytes = 0;
  std::uint64_t incident_bytes = 0;
  std::size_t accepted = 0;
  std::size_t incidents = 0;
  for (const auto& [name, run] : runs_) {
    if (run.accepted) {
      ++accepted;
      accepted_bytes += run.bytes;
    } else if (run.is_incident() && !run.acknowledged) {
      ++incidents;
      incident_bytes += run.bytes;
    }
  }
  return fmt::format(
      "the runs take {:.3f} GiB of {:g} GiB (retention.disk_budget_GiB) and retention may remove none of them: `eha "
      "runs remove RUN` frees up to {:.1f} MB of {} accepted runs, `eha runs ack RUN` releases {} incidents with "
      "{:.1f} MB; the newest {} are kept",
      static_cast<double>(bytes_) / kBytesPerGiB, static_cast<double>(budget_bytes) / kBytesPerGiB,
      static_cast<double>(accepted_bytes) / kBytesPerMB, accepted, incidents,
      static_cast<double>(incident_bytes) / kBytesPerMB, kNewestKept);
}

}  // namespace eha::service
