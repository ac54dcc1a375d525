// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/run_service.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "config/file_kind.hpp"
#include "config/prepared_experiment.hpp"
#include "config/tone_grid.hpp"
#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/model_list.hpp"
#include "daemon/eha/place_text.hpp"
#include "daemon/eha/rehearsal_text.hpp"
#include "daemon/eha/service_text.hpp"
#include "daemon/eha/short_report.hpp"
#include "daemon/eha/stop_on_signals.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;
using control::Client;

/// Follows one experiment through the service until it is over.
class Follower {
 public:
  Follower(const std::filesystem::path& socket, Client& client, std::int64_t entry, Console& console)
      : socket_(socket), client_(client), entry_(entry), console_(console) {}

  /// @returns the entry at its end; none when the user did not wait for the fit
  std::optional<Json> follow(const StopOnSignals& stop) {
    client_.call("watch", {{"entry", entry_}, {"rate_Hz", 10.0}});
    for (;;) {
      if (stop.count() > stops_seen_) {
        stops_seen_ = stop.count();
        if (!pass_on_stop()) return std::nullopt;
      }
      const std::optional<Json> status = client_.next_event(std::chrono::milliseconds(500));
      if (!status) continue;
      last_ = status->at("entry");
      if (status->value("last", false)) {
        console_.end_progress();
        return last_;
      }
      show(*status);
    }
  }

 private:
  void show(const Json& status) {
    const std::string state = last_.at("state");
    if (state == "waiting" || state == "held") {
      const std::string reason = last_.value("waits_for", "");
      if (reason != reason_)
        console_.info(
            fmt::format("experiment {} {} for {}", entry_, state == "held" ? "is held and waits" : "waits", reason));
      reason_ = reason;
    } else if (state == "running" && !status.at("run").is_null()) {
      console_.progress(share_played(status.at("run")), progress_text(status.at("run")));
    } else if (state == "fitting") {
      console_.progress(1.0, "fitting");
    }
  }

  /// @returns whether the entry can still change
  bool pass_on_stop() {
    console_.end_progress();
    const std::string state = last_.value("state", "waiting");
    // A second connection, because waiting for an answer on the first would skip the last event.
    Client other(socket_);
    if (state == "waiting" || state == "held") {
      try {
        other.call("cancel", {{"entry", entry_}});
        return true;
      } catch (const Error&) {
        // The experiment has started in the meantime.
      }
    }
    if (state == "fitting" || state == "judging") {
      console_.info(fmt::format("the run is over; ehad keeps fitting it, see eha status"));
      return false;
    }
    const Json answer = other.call("stop", {{"entry", entry_}});
    console_.info(answer.at("stopped") == "safe_at_once" ? "making the rig safe at once"
                                                         : "ramping out; Ctrl-C again makes the rig safe at once");
    return true;
  }

  std::filesystem::path socket_;
  Client& client_;
  std::int64_t entry_;
  Console& console_;
  Json last_ = Json::object();
  std::string reason_;
  int stops_seen_ = 0;
};

/// The answer as `eha run --local` gives it, from the run's folder; the list of models where that may not be read.
void print_answer_of_service(const Json& entry, const Console& console) {
  const std::filesystem::path folder = entry.value("folder", "");
  try {
    if (!folder.empty() && print_answer(folder, record::read_manifest(folder), console)) return;
  } catch (const Error& error) {
    console.debug(error.what());
  }
  print_model_list(record::models_from_json(entry.at("models"), "ehad's answer: models"), console);
}

ExitCode report(const Json& entry, const Console& console) {
  const auto code = static_cast<ExitCode>(entry.value("exit_code", static_cast<int>(ExitCode::bug)));
  const std::string folder = entry.value("folder", "");
  const std::string note = entry.value("note", "");
  if (code != ExitCode::ok && !note.empty()) console.error(note);
  if (!folder.empty() && note.find("travel_limit") != std::string::npos) explain_trip(folder, console);
  if (!folder.empty() && entry.value("outcome", "") != "completed") {
    console.info(fmt::format("what was recorded is in {}; `eha fit {}` fits it all the same", folder, folder));
  }
  console.print_json({{"schema", "eha-run/1"},
                      {"run", folder},
                      {"outcome", entry.at("state") == "cancelled" ? Json("cancelled") : entry.at("outcome")},
                      {"models", entry.at("models")},
                      {"exit_code", static_cast<int>(code)}});
  if (entry.value("placed_in", Json()).is_number()) {
    if (code == ExitCode::ok) print_place(entry.at("placed_in").get<double>(), console);
    return code;
  }
  print_answer_of_service(entry, console);
  if (code == ExitCode::ok) console.next_step(fmt::format("eha runs show {}", folder));
  return code;
}

/// Rehearses an experiment with the service's rig file, where this user may read it. What is wrong with either file is
/// the service's to say.
void rehearse_for_service(const RunCommand& command, const std::string& text, const Json& status, Console& console) {
  try {
    const config::RigConfig rig = config::load_rig(status.at("rig").at("file").get<std::string>());
    const config::PreparedExperiment prepared = config::parse_prepared_experiment(text, command.experiment_file, rig);
    for (const std::string& sentence : config::off_grid_tones(prepared.config)) console.warning(sentence);
    const Json rod = status.value("rod", Json());
    const bool is_read = rod.is_object() && rod.contains("displacement_in");
    const double place_in = is_read ? rod.at("displacement_in").get<double>() : start_of(rig);
    report_rehearsal(rehearse(prepared, rig, place_in), command.experiment_file, console);
  } catch (const Error& error) {
    console.debug(fmt::format("not rehearsed: {}", error.what()));
  }
}

}  // namespace

ExitCode run_through_service(const RunCommand& command, Console& console) {
  const std::string text = command.text ? *command.text : config::read_config_file(command.experiment_file);
  Client client(command.socket);
  const Json status = client.call("status");
  const Json& rig = status.at("rig");
  rehearse_for_service(command, text, status, console);
  if (rig.at("moves") == true && !command.yes &&
      !console.confirm(fmt::format("This moves the actuator of \"{}\" ({}) with {}.", rig.at("name").get<std::string>(),
                                   rig.at("file").get<std::string>(), command.experiment_file))) {
    console.info("not confirmed; nothing was moved");
    return ExitCode::interrupted;
  }
  // From here on Ctrl-C stops the rig; closing the terminal does not.
  const StopOnSignals stop(Driver::service);
  const Json queued =
      client.call("submit", {{"experiment", text}, {"name", command.experiment_file}, {"fast", command.fast}});
  const std::int64_t number = queued.at("entry");
  console.info(fmt::format("experiment {} \"{}\" on {} ({})", number, queued.at("name").get<std::string>(),
                           rig.at("name").get<std::string>(), rig.at("file").get<std::string>()));
  const std::optional<Json> entry = Follower(command.socket, client, number, console).follow(stop);
  return entry ? report(*entry, console) : ExitCode::interrupted;
}

}  // namespace eha::cli
