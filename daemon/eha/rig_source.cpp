// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/rig_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstddef>
#include <span>
#include <system_error>
#include <vector>

#include "config/file_kind.hpp"
#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/drive_options.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/rig/narrower_limits.hpp"
#include "hal/backends/backend.hpp"

namespace eha::cli {
namespace {

namespace fs = std::filesystem;

}  // namespace

std::optional<fs::path> default_rig_file() {
  std::error_code ignored;
  const std::array<fs::path, 2> fixed{"/etc/ehad/rig.toml", fs::path(EHA_DATA_DIR) / "rigs" / "sim.toml"};
  for (const fs::path& path : fixed) {
    if (fs::is_regular_file(path, ignored)) return path;
  }
  const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
  for (fs::path folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path()) {
    const std::array<fs::path, 2> near{folder / "share" / "ehad" / "rigs" / "sim.toml",
                                       folder / "config" / "rigs" / "sim.toml"};
    for (const fs::path& path : near) {
      if (fs::is_regular_file(path, ignored)) return path;
    }
  }
  return std::nullopt;
}

config::RigConfig load_rig_or_default(const std::optional<std::string>& rig_file) {
  if (rig_file) return config::load_rig(*rig_file);
  const std::optional<fs::path> found = default_rig_file();
  if (!found) {
    throw UsageError(
        fmt::format("no rig file: neither /etc/ehad/rig.toml nor {}/rigs/sim.toml is there; name one "
                    "with --rig",
                    EHA_DATA_DIR));
  }
  return config::load_rig(found->string());
}

bool default_rig_moves_machine() {
  try {
    return hal::moves_machine(load_rig_or_default({}).backend);
  } catch (const Error&) {
    return true;
  }
}

std::optional<FileChange> change_since_read(const nlohmann::ordered_json& rig) {
  const std::string file = rig.at("file");
  std::error_code unknown;
  if (const fs::file_status found = fs::status(file, unknown); found.type() == fs::file_type::not_found) {
    return FileChange{file + " is gone since ehad read it", "put it back, then"};
  }
  try {
    const std::string text = config::read_config_file(file);
    if (record::sha256_of(std::as_bytes(std::span(text))) == rig.value("sha256", "")) return std::nullopt;
    const config::RigConfig edited = config::parse_rig(text, file);
    config::RigConfig in_force = edited;
    if (rig.contains("limits")) {
      const nlohmann::ordered_json& limits = rig.at("limits");
      in_force.limits.travel_min_in = limits.at("travel_min_in");
      in_force.limits.travel_max_in = limits.at("travel_max_in");
      in_force.limits.command_min_V = limits.at("command_min_V");
      in_force.limits.command_max_V = limits.at("command_max_V");
      for (const auto& [key, limit] :
           {std::pair{"velocity_limit_in_per_s", &config::RigLimits::velocity_limit_in_per_s},
            std::pair{"slew_V_per_s", &config::RigLimits::slew_V_per_s}}) {
        if (limits.contains(key)) in_force.limits.*limit = limits.at(key);  // a service of before lacks it
      }
    }
    const std::vector<std::string> narrower = narrower_limits(in_force, edited);
    if (narrower.empty()) return FileChange{file + " was edited since ehad read it", ""};
    return FileChange{fmt::format("{} was edited since ehad read it and has narrower limits ({}), so that nothing "
                                  "begins to move",
                                  file, fmt::join(narrower, ", ")),
                      ""};
  } catch (const ConfigError& error) {
    return FileChange{
        fmt::format("{} was edited since ehad read it and is not valid now, so that nothing begins to move "
                    "({})",
                    file, error.what()),
        "correct it, then"};
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<ServiceRig> rig_of_service(const std::filesystem::path& socket, const Console& console) {
  std::error_code ignored;
  if (!std::filesystem::exists(socket, ignored)) return std::nullopt;
  try {
    control::Client client(socket);
    const nlohmann::ordered_json status = client.call("status");
    ServiceRig found{.file = status.at("rig").at("file"),
                     .name = status.at("rig").at("name"),
                     .moves = status.at("rig").at("moves"),
                     .place_in = std::nullopt};
    found.change = change_since_read(status.at("rig"));
    const nlohmann::ordered_json rod = status.value("rod", nlohmann::ordered_json());
    found.is_moving = !status.at("run").is_null();
    found.is_disarmed = status.at("reason").is_string();  // why it is not armed
    if (rod.is_object() && rod.contains("displacement_in")) found.place_in = rod.at("displacement_in");
    return found;
  } catch (const Error& error) {
    console.debug(error.what());
    return std::nullopt;
  }
}

suggest::RigAccess access_of(const ServiceRig& service, const fs::path& socket) {
  suggest::RigAccess rig = access_of(DriveOptions{.socket = socket});
  rig.is_disarmed = service.is_disarmed;
  return rig;
}

std::string run_of(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                   const suggest::RigAccess& access, const Console& console) {
  const std::vector<std::string> files{experiment.file_name};
  if (access.is_local) return suggest::run(access, files);
  try {
    static_cast<void>(config::parse_experiment(experiment.text, experiment.file_name, config::NamedFiles::refuse));
    return suggest::run(access, files);
  } catch (const ConfigError& error) {
    console.warning(error.what());
  }
  if (!hal::moves_machine(rig.backend)) return suggest::run(simulated_access(rig_name(rig.file_name)), files);
  return "sudo systemctl stop ehad && " + suggest::run({.is_local = true, .rig_file = rig_name(rig.file_name)}, files);
}

void require_as_read(const ServiceRig& service) {
  if (!service.change) return;
  throw UsageError(
      fmt::format("{}, and the limits of before are in force; {}{}put it in force with eha reload, or name a rig file "
                  "with --rig",
                  service.change->what, service.change->first, service.change->first.empty() ? "" : " "));
}

void warn_if_edited(const nlohmann::ordered_json& rig, const std::filesystem::path& socket, const Console& console) {
  const std::optional<FileChange> change = change_since_read(rig);
  if (!change) return;
  console.warning(fmt::format("{}, and the limits of before are in force; {}{}`{}` (while disarmed) puts it in force",
                              change->what, change->first, change->first.empty() ? "" : " ",
                              through(socket, "eha reload")));
}

void warn_of_rig_file(const nlohmann::ordered_json& rig, const Console& console) {
  if (change_since_read(rig)) return;
  try {
    const config::RigConfig read = config::load_rig(rig.at("file").get<std::string>());
    for (const std::string& sentence : arming_findings(read).warnings) console.warning(sentence);
  } catch (const Error& error) {
    console.debug(fmt::format("the rig file is not judged: {}", error.what()));
  }
}

}  // namespace eha::cli
