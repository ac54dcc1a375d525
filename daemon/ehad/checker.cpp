// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/checker.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::service {
namespace {

constexpr std::uint64_t kMostMemory = std::uint64_t{4} << 30U;  // bytes; the table of a day at 1 kHz takes 0.7 GB
constexpr std::string_view kPrefix = "eha: error: ";

std::string replace_all(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

}  // namespace

void Checker::add(Task task, Done done) {
  const auto place = task.is_urgent ? std::next(checks_.begin(), process_ ? 1 : 0) : checks_.end();
  checks_.insert(place, {std::move(task), std::move(done)});
  poll();
}

void Checker::poll() {
  if (process_) {
    const std::optional<worker::WorkerEnd> end = process_->poll();
    if (!end) return;
    process_.reset();
    const Check check = std::move(checks_.front());
    checks_.pop_front();
    check.done(*end);
  }
  if (process_ || checks_.empty()) return;
  const Task& next = checks_.front().task;
  worker::WorkerLimits limits;
  limits.cpu_time = kLongestWork;
  limits.wall_time = kLongestTime;
  limits.memory_bytes = kMostMemory;
  limits.avoided_cpu = next.avoided_cpu;
  try {
    std::vector<std::string> words{"check", next.experiment.string(), "--rig", next.rig.string(), "--quiet", "--json"};
    if (next.place_in) words.push_back(fmt::format("--at={:.6f}in", *next.place_in));
    if (next.accept_travel_risk) words.emplace_back("--accept-travel-risk");
    process_ = std::make_unique<worker::WorkerProcess>(programs_, words, limits);
  } catch (const Error& error) {
    const Check check = std::move(checks_.front());
    checks_.pop_front();
    check.done({static_cast<int>(error.exit_code()), error.what()});
  }
}

void Checker::end() noexcept {
  process_.reset();
  checks_.clear();
}

nlohmann::ordered_json rehearsal_of(const worker::WorkerEnd& end) {
  using Json = nlohmann::ordered_json;
  const Json document = Json::parse(end.output, nullptr, false);
  return document.is_object() ? document.value("rehearsal", Json()) : Json();
}

void write_checked_files(const std::filesystem::path& folder, const std::string& experiment,
                         const config::RigConfig& rig) {
  os::create_folders(folder);
  os::write_file_atomically(folder / kCheckedExperiment, experiment);
  os::write_file_atomically(folder / kCheckedRig, rig.text);
}

void throw_if_failed(const worker::WorkerEnd& end, const CheckedFile& experiment, const CheckedFile& rig) {
  if (end.exit_code == static_cast<int>(ExitCode::ok)) return;
  if (!end.exit_code) {
    throw IoError(
        fmt::format("{}: checking the experiment took more than {} s of processor time or {} s, or its process "
                    "was killed; make it shorter, or give it fewer tones",
                    experiment.name, Checker::kLongestWork.count(), Checker::kLongestTime.count()));
  }
  std::vector<std::string> lines;
  std::istringstream text(
      replace_all(replace_all(end.text, experiment.path.string(), experiment.name), rig.path.string(), rig.name));
  for (std::string line; std::getline(text, line);) {
    lines.push_back(line.starts_with(kPrefix) ? line.substr(kPrefix.size()) : line);
  }
  if (lines.empty()) lines.push_back(fmt::format("{}: eha check ended with code {}", experiment.name, *end.exit_code));
  const auto code = static_cast<ExitCode>(*end.exit_code);
  if (code == ExitCode::configuration) throw ConfigError(lines);
  throw Error(code, fmt::format("{}", fmt::join(lines, "\n")));
}

}  // namespace eha::service
