// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/terminal_text.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/eha/wrapped_text.hpp"
#include "daemon/record/manifest.hpp"

namespace eha::cli {

using Json = nlohmann::ordered_json;

std::string verdict_text(const Json& entry) {
  std::string text = entry.value("outcome", "");
  std::vector<std::string> accepted;
  for (const Json& model : entry.value("models", Json::array())) {
    if (model.value("accepted", false)) accepted.push_back(model.value("name", "?"));
  }
  if (!accepted.empty()) {
    text += fmt::format(", accepted: {}", fmt::join(accepted, ", "));
  } else if (!entry.value("models", Json::array()).empty()) {
    text += ", none accepted";
  }
  const std::string note = entry.value("note", "");
  // "interrupted by a stop request" needs no "interrupted" before it.
  if (!text.empty() && note.starts_with(text)) return note;
  if (!note.empty()) text += (text.empty() ? "" : ": ") + note;
  return text;
}

std::string progress_text(const Json& entry) {
  if (!entry.is_object()) return {};
  const std::string state = entry.value("state", "");
  if (state == "running") return "is being played";
  if (state == "judging") return "is being judged";
  if (state != "fitting") return {};
  const auto fitting_s = entry.find("fitting_s");
  if (fitting_s == entry.end()) return "waits for its fit";
  // A fit has the lowest priority, and receives the time that the machine's other programs leave.
  constexpr double kSettled_s = 20.0;
  constexpr double kSmallShare = 0.2;
  const double elapsed_s = fitting_s->get<double>();
  const double cpu_s = entry.value("fitting_cpu_s", 0.0);
  const bool is_starved = elapsed_s > kSettled_s && cpu_s < kSmallShare * elapsed_s;
  return fmt::format("is being fitted, for {} so far, with {:.0f} s of processor time{}", duration_text(elapsed_s),
                     cpu_s, is_starved ? " (other programs keep the processors busy)" : "");
}

Json entry_of_run(const std::filesystem::path& run, const std::filesystem::path& socket) {
  std::error_code ignored;
  if (!std::filesystem::exists(socket, ignored)) return nullptr;
  try {
    const Json queue = control::Client(socket).call("queue");
    for (const Json& entry : queue.at("entries")) {
      const std::string folder = entry.value("folder", "");
      if (!folder.empty() && std::filesystem::equivalent(folder, run, ignored)) return entry;
    }
  } catch (const Error&) {
    // No service answers: only the run's folder is known.
  }
  return nullptr;
}

std::vector<std::string> end_times(const nlohmann::ordered_json& entries) {
  std::vector<std::string> texts;
  std::optional<double> end_s;
  bool is_bound = false;
  for (const auto& entry : entries) {
    const std::string state = entry.at("state");
    const double duration_s = entry.value("duration_s", 0.0);
    std::tm start{};
    texts.emplace_back();
    if (entry.value("fast", false) || entry.value("only_places", false)) continue;
    if (state == "running" && strptime(entry.value("run", "").c_str(), "%Y%m%dT%H%M%SZ", &start) != nullptr) {
      end_s = static_cast<double>(timegm(&start)) + duration_s;
      // Of a rod that is still explored the end is known as a bound only, and of what waits behind it.
      is_bound = entry.contains("exploring_at_most_s");
      *end_s += entry.value(is_bound ? "exploring_at_most_s" : "preparing_s", 0.0);
    } else if (state == "waiting" && end_s) {
      *end_s += duration_s;
    } else {
      continue;
    }
    const auto seconds = static_cast<std::time_t>(*end_s);
    std::tm local{};
    localtime_r(&seconds, &local);
    texts.back() = fmt::format("{}{:02}:{:02}", is_bound ? "by " : "", local.tm_hour, local.tm_min);
  }
  return texts;
}

namespace {

/// Cuts a name to at most `width` bytes, characters of UTF-8 whole: --json has all of it.
std::string cut_to_width(const std::string& text, std::size_t width) {
  if (text.size() <= width) return text;
  std::size_t end = width - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end) + "...";
}

/// The result of an experiment, or what it waits for; why it ended so, whole.
std::string result_text(const Json& entry) {
  const std::string state = entry.at("state");
  if (state == "running") return {};
  if (state == "waiting" || state == "held") return "waits for " + wait_of(entry.value("waits_for", "")).command;
  if (state == "fitting" && entry.contains("fitting_s")) {
    return fmt::format("for {} so far", duration_text(entry.at("fitting_s").get<double>()));
  }
  if (state == "cancelled") return verdict_text(entry);
  if (state != "over") return progress_text(entry);
  const std::string outcome = entry.value("outcome", "");
  const std::string note = entry.value("note", "");
  const Json models = entry.value("models", Json::array());
  const auto accepted =
      std::count_if(models.begin(), models.end(), [](const Json& model) { return model.value("accepted", false); });
  // The run has the rest of a fault: what it may come from, and what to do.
  if (const std::string run = entry.value("run", ""); outcome == "faulted" && !run.empty()) {
    Json end = entry;
    end["note"] = record::without_remedy(note);
    return fmt::format("{}; eha runs show {} says more", verdict_text(end), run);
  }
  if (!note.empty() || models.empty()) return verdict_text(entry);
  return accepted > 0 ? fmt::format("{}, {} accepted", outcome, accepted) : outcome + ", none accepted";
}

}  // namespace

Wait wait_of(const std::string& waits_for) {
  const std::size_t colon = waits_for.find(": ");
  if (colon == std::string::npos) return {waits_for, {}};
  return {waits_for.substr(0, colon), waits_for.substr(colon + 2)};
}

namespace {

/// Indices of the entries as they are listed: the last five that are over, by when their runs began, then the others by
/// their places in the queue. One that was refused or cancelled stands behind the latest run of a lower number.
std::vector<std::size_t> listed(const Json& entries) {
  constexpr std::size_t kMostOver = 5;
  constexpr std::size_t kTime = 16;  // of a run's name, which its second begins
  std::vector<std::pair<std::string, std::size_t>> over;
  std::vector<std::size_t> others;
  std::string latest;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string state = entries[i].at("state");
    const std::string run = entries[i].value("run", "");
    latest = std::max(latest, run);
    if (state == "over" || state == "cancelled") {
      over.emplace_back((run.empty() ? latest : run).substr(0, kTime), i);
    } else {
      others.push_back(i);
    }
  }
  std::stable_sort(over.begin(), over.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::size_t> all;
  for (std::size_t i = over.size() - std::min(over.size(), kMostOver); i < over.size(); ++i) {
    all.push_back(over[i].second);
  }
  all.insert(all.end(), others.begin(), others.end());
  return all;
}

}  // namespace

std::string queue_table(const Json& entries) {
  constexpr std::size_t kLine = 100;
  constexpr std::size_t kIndent = 8;
  constexpr std::size_t kLongestName = 20;
  constexpr std::size_t kLongestUser = 10;
  std::vector<std::vector<std::string>> rows;
  const std::vector<std::string> ends = end_times(entries);
  for (const std::size_t i : listed(entries)) {
    const Json& entry = entries[i];
    const std::string state = entry.at("state");
    const double duration_s = entry.value("only_places", false) ? 0.0 : entry.value("duration_s", 0.0);
    rows.push_back({fmt::format("{}{}", state == "running" ? "> " : "", entry.at("entry").get<std::int64_t>()),
                    cut_to_width(entry.value("name", ""), kLongestName),
                    cut_to_width(entry.value("user", ""), kLongestUser), state,
                    duration_s > 0.0 ? fmt::format("{:.0f}", duration_s) : "-", ends[i], entry.value("run", ""),
                    result_text(entry)});
  }
  if (rows.empty()) return "no experiments in the queue\n";
  std::vector<Column> columns{{"number", Align::right}, {"experiment"}, {"of"}, {"state"},
                              {"s", Align::right},      {"ends"}};
  std::size_t before = 0;  // the last column
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::size_t width = columns[i].title.size();
    for (const auto& row : rows) width = std::max(width, row[i].size());
    before += width + 2;
  }
  std::vector<std::string> below;  // results that are too long to stand beside the run
  for (auto& row : rows) {
    // The name of a run stays whole: `eha runs show` takes it.
    const std::string& run = row[columns.size()];
    std::string& said = row[columns.size() + 1];
    const std::size_t taken = before + run.size() + (run.empty() ? 0 : 2);
    const bool has_room = said.empty() || taken + said.size() <= kLine;
    below.push_back(has_room ? std::string() : std::string(kIndent, ' ') + wrapped(one_line(said), kIndent) + "\n");
    said = fmt::format("{}{}{}", run, run.empty() || said.empty() || !has_room ? "" : "  ", has_room ? said : "");
    row.erase(row.end() - 2);
  }
  columns.push_back({"run and result"});
  const std::string lines = text_table(columns, rows);
  std::size_t at = lines.find('\n', lines.find('\n') + 1) + 1;  // behind the heading and its rule
  std::string table = lines.substr(0, at);
  for (const std::string& result : below) {
    const std::size_t end = lines.find('\n', at) + 1;
    table += lines.substr(at, end - at) + result;
    at = end;
  }
  for (const Json& entry : entries) {
    if (entry.at("state") != "held") continue;
    const Wait wait = wait_of(entry.value("waits_for", ""));
    if (!wait.why.empty()) table += fmt::format("{} is held: {}\n", entry.at("entry").get<std::int64_t>(), wait.why);
  }
  return table;
}

}  // namespace eha::cli
