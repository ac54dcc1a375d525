// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/priorities.hpp"
#include "daemon/control/client.hpp"
#include "daemon/delays/delays.hpp"
#include "daemon/doctor/card_checks.hpp"
#include "daemon/doctor/check.hpp"
#include "daemon/doctor/delay_checks.hpp"
#include "daemon/doctor/limit_checks.hpp"
#include "daemon/doctor/machine_checks.hpp"
#include "daemon/doctor/privileges.hpp"
#include "daemon/doctor/run_folder_check.hpp"
#include "daemon/eha-safe/guard_process.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/command_list.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/rig/trusted_file.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

using doctor::Check;
using Json = nlohmann::ordered_json;

constexpr const char* kDoctorFooter = R"(
Checks kernel, scheduling, limits, CPUs, what can make ticks late, and disk; for a rig on a card also the device, its
driver, board and safety lines. Without --rig it is the service's rig, where one runs, and the limits are those of the
service, which drives it; with --rig they are the caller's. Each line is ok, warn or fail; warn and fail name the remedy. Nothing is changed and nothing moves.
Exit code, of the worst failure: 78 rig file, 69 device, 77 permission, 74 disk; 0 without a failure.

Examples:
  eha doctor
  eha doctor --rig /etc/ehad/rig.toml --json)";

struct DoctorCommand {
  std::optional<std::string> rig_file = {};  ///< none: the service's, or default_rig_file()
  std::filesystem::path output = "runs";     ///< where run folders would go
};

constexpr const char* kRoot = "/";

void append(std::vector<Check>& checks, std::vector<Check> more) {
  checks.insert(checks.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

/// Reads the rig file; errors in it become a failed check.
std::optional<config::RigConfig> load_rig(const std::optional<std::string>& file, std::vector<Check>& checks) {
  try {
    config::RigConfig rig = load_rig_or_default(file);
    const std::string_view backend = hal::moves_machine(rig.backend) ? hal::name_of(rig.backend) : "simulated";
    checks.push_back(doctor::ok("rig file", fmt::format("{}: \"{}\", {}", rig.file_name, rig.name, backend)));
    return rig;
  } catch (const UsageError& error) {
    checks.push_back(
        doctor::fail("rig file", error.what(), "write /etc/ehad/rig.toml, see eha-rig(5)", ExitCode::configuration));
  } catch (const PermissionError& error) {
    checks.push_back(
        doctor::fail("rig file", error.what(), "ask its owner for permission to read it", error.exit_code()));
  } catch (const Error& error) {
    checks.push_back(doctor::fail("rig file", error.what(),
                                  fmt::format("correct the named lines, see eha-rig(5), then: eha check {}",
                                              file ? shell_word(*file) : "/etc/ehad/rig.toml"),
                                  error.exit_code()));
  }
  return std::nullopt;
}

Check check_trust(const config::RigConfig& rig) {
  try {
    require_trusted_rig_file(rig);
  } catch (const Error& error) {
    return doctor::fail("rig file owner", error.what(),
                        fmt::format("sudo chown root {0} && sudo chmod go-w {0}", shell_word(rig.file_name)),
                        error.exit_code());
  }
  if (hal::moves_machine(rig.backend) && !is_site_rig_file(rig.file_name)) {
    return doctor::warn("rig file owner",
                        "root, and no one else may write it; not in /etc/ehad: with --local only root "
                        "drives the rig by it",
                        "sudo cp " + shell_word(rig.file_name) + " /etc/ehad/rig.toml");
  }
  return doctor::ok("rig file owner", "root, and no one else may write it");
}

Check check_guard() {
  try {
    return doctor::ok("guard", guard_program().string());
  } catch (const Error& error) {
    return doctor::fail("guard", error.what(), "install ehad anew", error.exit_code());
  }
}

void show(const std::vector<Check>& checks, ExitCode code, Console& console) {
  Json document{{"schema", "eha-doctor/1"}, {"checks", Json::array()}, {"exit_code", static_cast<int>(code)}};
  for (const Check& check : checks) {
    document["checks"].push_back({{"name", check.name},
                                  {"level", doctor::to_text(check.level)},
                                  {"found", check.found},
                                  {"remedy", check.remedy}});
    std::string found = check.found;
    for (std::size_t at = found.find('\n'); at != std::string::npos; at = found.find('\n', at + 1)) {
      found.insert(at + 1, std::string(22, ' '));
    }
    console.print(fmt::format("{:<4}  {:<14}  {}", doctor::to_text(check.level), check.name, found));
    if (!check.remedy.empty()) console.print(fmt::format("{:<22}-> {}", "", check.remedy));
  }
  console.print_json(document);
}

/// The running service, whose rig is the relevant one.
struct Service {
  std::string rig_file;
  std::optional<pid_t> process = {};
};

/// @returns none if no service answers
std::optional<Service> running_service() {
  std::error_code ignored;
  if (!std::filesystem::exists(control::default_socket(), ignored)) return std::nullopt;
  try {
    control::Client client(control::default_socket());
    return Service{.rig_file = client.call("status").at("rig").at("file").get<std::string>(),
                   .process = client.service_process()};
  } catch (const Error&) {
    return std::nullopt;
  }
}

/// Those of the service, which drives; else the caller's.
doctor::Privileges privileges_that_count(const std::optional<Service>& service, int priority) {
  const doctor::Privileges caller = doctor::probe_privileges(priority);
  if (!service || !service->process) return caller;
  const auto process = std::filesystem::path(kRoot) / "proc" / std::to_string(*service->process);
  return doctor::privileges_of_service(process, caller).value_or(caller);
}

ExitCode execute(const DoctorCommand& command, Console& console) {
  std::vector<Check> checks;
  const std::optional<Service> service = command.rig_file ? std::nullopt : running_service();
  const std::optional<config::RigConfig> rig =
      load_rig(service ? std::optional(service->rig_file) : command.rig_file, checks);
  const bool moves = rig && hal::moves_machine(rig->backend);
  const config::RealtimeOptions realtime = rig ? rig->realtime : config::RealtimeOptions{};
  const doctor::Machine machine{.kernel = acquisition::kernel_facts(),
                                .files = doctor::read_system_files(kRoot),
                                .privileges = privileges_that_count(service, realtime.priority)};
  append(checks, doctor::check_machine(machine, realtime, moves ? doctor::Stakes::machine : doctor::Stakes::simulated));
  delays::LoopThread loop{.cpu = realtime.cpu, .priority = std::min(realtime.priority, kHighestLoopPriority)};
  append(checks, doctor::check_delays(delays::standing_delays(kRoot, delays::read_counters(kRoot), loop), loop.cpu));
  if (moves) {
    checks.push_back(check_trust(*rig));
    if (const auto* card = std::get_if<hal::ComediOptions>(&rig->backend)) {
      append(checks, doctor::check_card(*card, doctor::find_card(*card, kRoot, machine.kernel.release)));
      append(checks, doctor::check_lines(*card));
    }
  }
  if (rig) checks.push_back(doctor::check_limits(*rig));
  if (moves) checks.push_back(check_guard());
  append(checks, doctor::check_runs_folder(doctor::look_at_runs_folder(command.output), realtime.sample_period_s));
  const ExitCode code = doctor::exit_code(checks);
  show(checks, code, console);
  if (code == ExitCode::ok)
    console.next_step("eha latency --load" + (command.rig_file ? " --rig " + shell_word(*command.rig_file) : ""));
  return code;
}

}  // namespace

void add_doctor(CLI::App& app, ParsedLine& line) {
  CLI::App* sub = app.add_subcommand("doctor", "Check that this machine and its rig are fit for experiments");
  sub->footer(kDoctorFooter);
  auto& doctor = options_of<DoctorCommand>(*sub, line);
  sub->add_option("--rig", doctor.rig_file, "Rig file (TOML; default the service's)")->type_name("RIG");
  sub->add_option("--output", doctor.output, "Folder that run folders would be put into (default runs)")
      ->type_name("DIR");
}

}  // namespace eha::cli
