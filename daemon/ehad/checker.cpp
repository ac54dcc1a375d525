// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/checker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
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

std::string why_not_checked(const worker::WorkerEnd& end) {
  switch (end.ended_by) {
    case worker::EndedBy::wall_time:
      return fmt::format(
          "the check, which has a low priority, was not done after {} s: the machine is busy; give the command again "
          "once it is less so (`eha queue` shows what the service still fits, `top` what else runs)",
          Checker::kLongestTime.count());
    case worker::EndedBy::processor_time:
      return fmt::format(
          "the check takes more than {} s of processor time: make the experiment shorter, or give it fewer tones",
          Checker::kLongestWork.count());
    case worker::EndedBy::own_limit:
    case worker::EndedBy::signal:
    case worker::EndedBy::itself:
      break;
  }
  return replace_all(end.text, "the identification", "the check");
}

}  // namespace

void Checker::add(Task task, Done done) {
  waiting_.push_back({std::move(task), std::move(done)});
  poll();
}

void Checker::poll() {
  // `done` may add another check.
  while (report()) {
  }
  const auto now = Clock::now();
  while (!spent_.empty() && now - spent_.front().ended > kLately) spent_.pop_front();
  for (auto chosen = next(); chosen != waiting_.end(); chosen = next()) {
    Check check = std::move(*chosen);
    waiting_.erase(chosen);
    start(std::move(check));
  }
}

bool Checker::report() {
  for (auto running = running_.begin(); running != running_.end(); ++running) {
    const std::optional<worker::WorkerEnd> end = running->process->poll();
    if (!end) continue;
    const auto now = Clock::now();
    spent_.push_back({running->check.task.user, now, now - running->begun});
    const Check check = std::move(running->check);
    running_.erase(running);
    check.done(*end);
    return true;
  }
  return false;
}

std::deque<Checker::Check>::iterator Checker::next() {
  const auto is_urgent = [](const Check& check) { return check.task.is_urgent; };
  const auto urgent_on =
      std::count_if(running_.begin(), running_.end(), [&](const Running& running) { return is_urgent(running.check); });
  if (urgent_on == 0) {
    const auto urgent = std::find_if(waiting_.begin(), waiting_.end(), is_urgent);
    if (urgent != waiting_.end()) return urgent;
  }
  if (running_.size() - static_cast<std::size_t>(urgent_on) >= kMostAtOnce) return waiting_.end();
  auto best = waiting_.end();
  for (auto check = waiting_.begin(); check != waiting_.end(); ++check) {
    const uid_t user = check->task.user;
    const bool has_one_on = std::any_of(running_.begin(), running_.end(), [&](const Running& running) {
      return running.check.task.user == user && !is_urgent(running.check);
    });
    if (is_urgent(*check) || has_one_on) continue;
    if (best == waiting_.end() || spent_by(user) < spent_by(best->task.user)) best = check;
  }
  return best;
}

Checker::Clock::duration Checker::spent_by(uid_t user) const {
  Clock::duration sum{};
  for (const Spent& spent : spent_) sum += spent.user == user ? spent.time : Clock::duration{};
  return sum;
}

void Checker::start(Check check) {
  const Task& task = check.task;
  worker::WorkerLimits limits;
  limits.cpu_time = kLongestWork;
  limits.wall_time = kLongestTime;
  limits.memory_bytes = kMostMemory;
  limits.avoided_cpu = task.avoided_cpu;
  limits.nice = worker::kCheckNice;
  try {
    std::vector<std::string> words{"check", task.experiment.string(), "--rig", task.rig.string(), "--quiet", "--json"};
    if (task.place_in) words.push_back(fmt::format("--at={:.6f}in", *task.place_in));
    if (task.accept_travel_risk) words.emplace_back("--accept-travel-risk");
    auto process = std::make_unique<worker::WorkerProcess>(programs_, words, limits);
    running_.push_back({std::move(check), std::move(process), Clock::now()});
  } catch (const Error& error) {
    check.done({static_cast<int>(error.exit_code()), error.what()});
  }
}

void Checker::end() noexcept {
  running_.clear();
  waiting_.clear();
}

nlohmann::ordered_json rehearsal_of(const worker::WorkerEnd& end) {
  using Json = nlohmann::ordered_json;
  const Json document = Json::parse(end.output, nullptr, false);
  return document.is_object() ? document.value("rehearsal", Json()) : Json();
}

double duration_of(const worker::WorkerEnd& end) {
  using Json = nlohmann::ordered_json;
  const Json document = Json::parse(end.output, nullptr, false);
  return document.is_object() ? document.value("duration_s", 0.0) : 0.0;
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
    throw IoError(fmt::format("{}: not checked: {}", experiment.name, why_not_checked(end)));
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

bool ListFindings::take(const worker::WorkerEnd& end, const CheckedFile& experiment, const CheckedFile& rig) {
  try {
    throw_if_failed(end, experiment, rig);
    return true;
  } catch (const Error&) {
    if (end.exit_code) {
      fault_ = std::current_exception();
      return false;
    }
    if (not_checked_) return false;
    not_checked_ = std::current_exception();
    return true;
  }
}

void ListFindings::throw_if_any() const {
  if (!fault_ && !not_checked_) return;
  if (!fault_) std::rethrow_exception(not_checked_);
  if (!not_checked_) std::rethrow_exception(fault_);
  std::string not_checked;
  try {
    std::rethrow_exception(not_checked_);
  } catch (const Error& error) {
    not_checked = error.what();
  }
  try {
    std::rethrow_exception(fault_);
  } catch (const ConfigError& error) {
    std::vector<std::string> lines = error.lines();
    lines.push_back(not_checked);
    throw ConfigError(lines);
  } catch (const Error& error) {
    throw Error(error.exit_code(), fmt::format("{}\n{}", error.what(), not_checked));
  }
}

}  // namespace eha::service
