// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "daemon/control/client.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/rod_status.hpp"
#include "daemon/eha/rod_text.hpp"
#include "daemon/eha/service_command.hpp"
#include "daemon/eha/stop_on_signals.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/rod_view.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kReadFooter = R"(
Shows where the rod is, on a bar between its limits ('=': beyond 80 % of the way to a limit), the sensor's voltage
[V], code and noise, the digital lines and whether the rig is armed. Moves nothing. Asks the service; where none
listens at the default socket, or with --local, it reads the rig of --rig itself. --watch redraws it until Ctrl-C.

Examples:
  eha read
  eha read --watch --units mm
  eha read --local --rig rig.toml)";

struct ReadCommand {
  std::optional<std::filesystem::path> socket = {};  ///< none: the default one, or the rig itself if no service answers
  std::optional<std::string> rig_file = {};          ///< with `local`; none: default_rig_file()
  bool local = false;                                ///< read the rig in this process
  bool watch = false;                                ///< repeatedly
};

constexpr double kReads_Hz = 5.0;

/// Result of a reading, with the state of the rig: {state, rig, rod}.
using Reader = std::function<Json()>;

Reader reader_of_service(control::Client& client) {
  return [&client] {
    const Json status = status_with_rod(client);
    return Json{{"schema", "eha-read/1"},
                {"state", status.at("state")},
                {"said", state_text(status)},
                {"rig", status.at("rig")},
                {"rod", status.at("rod")}};
  };
}

/// Reads an undriven rig, as often as the noise estimate needs.
Reader reader_of_rig(hal::Rig& rig, const config::RigConfig& config, RodView& view) {
  view.begin(rig.capabilities());
  return [&rig, &config, &view] {
    const auto tick = std::chrono::nanoseconds(std::llround(config.realtime.sample_period_s * 1e9));
    for (std::size_t i = 0; i < RodView::kKept; ++i) {
      if (i > 0) std::this_thread::sleep_for(tick);
      hal::RigReading reading;
      if (const hal::RigStatus status = rig.read(0, reading); status != hal::RigStatus::ok) {
        view.fail(status);
        break;
      }
      view.add(reading);
    }
    return Json{{"schema", "eha-read/1"},
                {"state", "not driven"},
                {"rig", {{"name", config.name}, {"file", config.file_name}, {"units", config.units}}},
                {"rod", view.describe(config.limits)}};
  };
}

std::string text_of(const Json& read, const Console& console) {
  const Json& rig = read.at("rig");
  std::vector<NamedText> lines = rod_lines(read.at("rod"), console.unit(rig.value("units", "")));
  lines.push_back(
      {"rig", fmt::format("{} ({})", rig.at("name").get<std::string>(), rig.at("file").get<std::string>())});
  lines.push_back({"state", read.value("said", read.at("state").get<std::string>())});
  return aligned(lines);
}

/// Returns the command that moves a rod near or beyond a limit to mid-travel; empty elsewhere.
std::string next_of(const ReadCommand& command, const Json& now, const Console& console) {
  const std::string way = way_to_middle(now.at("rod"), console.unit(now.at("rig").value("units", "")));
  if (way.empty()) return {};
  const std::string state = now.at("state");
  if (state == "not driven") {
    return way + " --local" + (command.rig_file ? " --rig " + shell_word(*command.rig_file) : std::string());
  }
  const std::filesystem::path socket = command.socket.value_or(control::default_socket());
  const bool must_arm = state == "faulted" || state == "idle";
  return (must_arm ? through(socket, "eha arm") + " && " : std::string()) + through(socket, way);
}

ExitCode show_readings(const ReadCommand& command, const Reader& read, Console& console) {
  if (!command.watch) {
    const Json now = read();
    console.print(text_of(now, console));
    console.print_json(now);
    const Json& rod = now.at("rod");
    if (const std::string next = next_of(command, now, console); !next.empty()) console.next_step(next);
    return rod.is_object() && rod.at("error").is_string() ? ExitCode::device_unavailable : ExitCode::ok;
  }
  const StopOnSignals stop(Driver::service);
  while (stop.count() == 0) {
    const Json now = read();
    if (console.json()) {
      console.print_content(now.dump() + "\n");
      console.flush();
    } else {
      console.redraw(text_of(now, console));
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(console.json() ? 1.0 : 1.0 / kReads_Hz));
  }
  return ExitCode::ok;
}

ExitCode execute(const ReadCommand& command, Console& console) {
  std::error_code ignored;
  const std::filesystem::path socket = command.socket.value_or(control::default_socket());
  // A user who named a service wants its rig, not another one that happens to be readable here.
  const bool is_named = command.socket || socket != control::kDefaultSocket;
  if (!command.local && (is_named || std::filesystem::exists(socket, ignored))) {
    control::Client client(socket);
    return show_readings(command, reader_of_service(client), console);
  }
  const config::RigConfig config = load_rig_or_default(command.rig_file);
  if (!command.local) {
    console.info(fmt::format("no ehad listens at {}; reading {} in this process", socket.string(), config.file_name));
  }
  // Opening it writes the file's safe voltage.
  require_local_rig_file(config);
  const std::unique_ptr<hal::Rig> rig = open_at_rest(config);
  RodView view;
  return show_readings(command, reader_of_rig(*rig, config, view), console);
}

}  // namespace

void add_read(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("read", "Show the rod, its sensor and the digital lines; moves nothing");
  sub->footer(kReadFooter);
  auto& read = options_of<ReadCommand>(*sub, line);
  CLI::Option* local = sub->add_flag("--local", read.local, "Read the rig in this process instead of through ehad");
  add_socket_option(*sub, read.socket)->excludes(local);
  sub->add_option("--rig", read.rig_file, "Rig file (TOML); with --local only")->type_name("RIG")->needs(local);
  sub->add_flag("--watch", read.watch, "Repeat until Ctrl-C");
}

}  // namespace eha::cli
