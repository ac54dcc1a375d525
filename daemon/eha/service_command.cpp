// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/control/client.hpp"
#include "daemon/eha/commands.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/recent_samples.hpp"
#include "daemon/eha/rod_text.hpp"
#include "daemon/eha/run_line.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/eha/text_table.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using control::Client;

/// The experiments that are not over, and the last few that are over.
std::string queue_table(const Json& entries) {
  constexpr std::size_t kMostOver = 5;
  std::vector<std::vector<std::string>> rows;
  std::size_t over = 0;
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    const std::string state = entry->at("state");
    const bool is_over = state == "over" || state == "cancelled";
    if (is_over && ++over > kMostOver) continue;
    const bool waits = state == "waiting" || state == "held";
    const std::string said = waits                ? "waits for " + entry->value("waits_for", "")
                             : state == "running" ? std::string()
                                                  : verdict_text(*entry);
    rows.insert(rows.begin(), {fmt::format("{}", entry->at("entry").get<std::int64_t>()), entry->value("name", ""),
                               entry->value("user", ""), state, said});
  }
  if (rows.empty()) return "no experiments in the queue\n";
  return text_table({{"number", Align::right},
                     {"experiment", Align::left},
                     {"of", Align::left},
                     {"state", Align::left},
                     {"", Align::left}},
                    rows);
}

std::string status_text(const Json& status, const Console& console) {
  std::vector<NamedText> lines;
  const Json& reason = status.at("reason");
  lines.push_back({"state", fmt::format("{}{}", status.at("state").get<std::string>(),
                                        reason.is_string() ? fmt::format(" ({})", reason.get<std::string>()) : "")});
  const Json& rig = status.at("rig");
  lines.push_back(
      {"rig", fmt::format("{} ({})", rig.at("name").get<std::string>(), rig.at("file").get<std::string>())});
  const DisplayUnit unit = console.unit(rig.value("units", ""));
  for (NamedText& line : rod_lines(status.value("rod", Json()), unit)) lines.push_back(std::move(line));
  const Json& lease = status.at("lease");
  lines.push_back({"lease", lease.is_null()
                                ? "none"
                                : fmt::format("held by {}, {:.0f} s left", lease.at("user").get<std::string>(),
                                              lease.at("remaining_s").get<double>())});
  if (const Json& run = status.at("run"); !run.is_null()) {
    const RunProgress progress = progress_of(status);
    lines.push_back({"run", fmt::format("{} \"{}\" of {}", run.at("entry").get<std::int64_t>(), run.value("name", ""),
                                        run.value("user", ""))});
    lines.push_back({"", run_line(progress, unit, std::chrono::system_clock::now())});
    lines.push_back({"loop", loop_line(progress)});
  }
  if (const Json& worker = status.at("worker"); !worker.is_null()) {
    lines.push_back(
        {"worker", fmt::format("fitting {} \"{}\"", worker.at("entry").get<std::int64_t>(), worker.value("name", ""))});
  }
  return aligned(lines);
}

ExitCode watch_status(Client& client, Console& console) {
  const StopOnSignals stop(Driver::service);
  client.call("watch", {{"rate_Hz", console.json() ? 1.0 : 5.0}, {"samples", true}});
  RecentSamples recent;
  while (stop.count() == 0) {
    const std::optional<Json> status = client.next_event(std::chrono::seconds(1));
    if (!status) continue;
    if (console.json()) {
      console.print_content(status->dump() + "\n");
      console.flush();
      continue;
    }
    recent.add(status->at("samples"));
    console.redraw(status_text(*status, console) +
                   aligned({{"last 1 s", recent.text(console.units())},
                            {"queue", fmt::format("{} waiting, {} held", status->at("waiting").get<int>(),
                                                  status->at("held").get<int>())}}));
  }
  return ExitCode::ok;
}

/// The name of a run's folder, from a name or a path.
std::string name_of(const std::string& run) {
  const std::filesystem::path path = std::filesystem::path(run).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

void print_numbers(const Json& numbers, const char* done, const char* none, const Console& console) {
  if (numbers.empty()) console.print(none);
  for (const Json& entry : numbers) console.print(fmt::format("experiment {} {}", entry.get<std::int64_t>(), done));
}

/// Prints an answer, and the next step.
void print_answer(const ServiceCommand& command, const Json& answer, const Console& console) {
  const auto next = [&](const char* what) { console.next_step(through(command.socket, what)); };
  if (command.method == "arm") {
    console.print(fmt::format("{}; you hold the lease for {:.0f} s", answer.at("state").get<std::string>(),
                              answer.at("lease_remaining_s").get<double>()));
    for (const Json& remark : answer.value("remarks", Json::array())) console.info(remark.get<std::string>());
    for (const Json& entry : answer.value("held", Json::array())) {
      console.print(fmt::format("held: {} \"{}\", submitted {}", entry.at("entry").get<std::int64_t>(),
                                entry.value("name", ""), entry.value("submitted", "")));
    }
    next(!answer.value("held", Json::array()).empty() ? "eha queue release"
         : answer.value("characterised", true)        ? "eha run EXPERIMENT.toml"
                                                      : "eha characterise");
  } else if (command.method == "release") {
    print_numbers(answer.at("released"), "released", "no experiment of yours is held", console);
    next("eha status");
  } else if (command.method == "hold") {
    print_numbers(answer.at("held"), "is held", "nothing was waiting", console);
    next("eha queue");
  } else if (command.method == "move") {
    console.print(fmt::format("experiment {} is number {} of {}'s", answer.at("entry").get<std::int64_t>(),
                              answer.at("position").get<std::int64_t>(), answer.value("user", "")));
    next("eha queue");
  } else if (command.method == "queue") {
    console.print(queue_table(answer.at("entries")));
  } else if (command.method == "disarm") {
    console.print("disarmed");
  } else if (command.method == "stop") {
    const std::string what = answer.at("stopped");
    console.print(what == "nothing"       ? "nothing was running"
                  : what == "disarmed"    ? "nothing was running; the rig is disarmed"
                  : what == "ramping_out" ? "ramping out; eha stop again makes the rig safe at once"
                                          : "the rig is made safe at once");
    if (what != "nothing") next("eha status");
  } else if (command.method == "reload") {
    console.print(fmt::format("configuration read again: {}", answer.at("rig").get<std::string>()));
  } else if (command.method == "ack") {
    console.print(fmt::format("{}: acknowledged; it may be removed when the disk budget is exceeded",
                              answer.at("run").get<std::string>()));
  } else if (command.method == "remove") {
    console.print(fmt::format("{}: removed, {:.1f} MB freed", answer.at("run").get<std::string>(),
                              answer.at("bytes").get<double>() * 1e-6));
  } else if (command.method == "cancel") {
    console.print(fmt::format("experiment {} cancelled", answer.at("entry").get<std::int64_t>()));
  }
}

/// Calls the method, for one experiment where it takes one.
ExitCode call_method(Client& client, const ServiceCommand& command, std::optional<std::int64_t> entry,
                     Console& console) {
  Json params = Json::object();
  if (entry) params["entry"] = *entry;
  if (command.to > 0) params["to"] = command.to;
  if (command.by != 0) params["by"] = command.by;
  if (!command.run.empty()) params["run"] = name_of(command.run);
  if (command.method == "remove" && !command.yes &&
      !console.confirm(fmt::format("This deletes {} with its record and models.", params["run"].get<std::string>()))) {
    console.info("not confirmed; nothing was deleted");
    return ExitCode::interrupted;
  }
  Json answer = client.call(command.method, params);
  if (command.method == "metrics") {
    console.print_content(answer.at("text").get<std::string>());
    return ExitCode::ok;
  }
  if (command.method == "status") {
    answer["queue"] = client.call("queue").at("entries");
    console.print(status_text(answer, console));
    console.print(queue_table(answer["queue"]));
  }
  print_answer(command, answer, console);
  console.print_json(answer);
  return ExitCode::ok;
}

}  // namespace

ExitCode execute(const ServiceCommand& command, Console& console) {
  Client client(command.socket);
  if (command.watch) return watch_status(client, console);
  if (command.entries.size() < 2) {
    return call_method(client, command, command.entries.empty() ? std::nullopt : std::optional(command.entries.front()),
                       console);
  }
  console.keep_documents();
  for (const std::int64_t entry : command.entries) call_method(client, command, entry, console);
  const Json documents = console.taken_documents();
  console.print_json({{"answers", documents}});
  console.next_step(through(command.socket, "eha queue"));
  return ExitCode::ok;
}

}  // namespace eha::cli
