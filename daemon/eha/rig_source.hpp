// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/suggest/commands.hpp"

namespace eha::cli {

/// Rig file of a local run without --rig: /etc/ehad/rig.toml, otherwise the simulated rig installed with the program,
/// otherwise the one in the source tree of the build. None if none of these exists.
[[nodiscard]] std::optional<std::filesystem::path> default_rig_file();

/// Reads the named rig file or the default one.
/// @throws UsageError  there is none; ConfigError, PermissionError as config::load_rig
[[nodiscard]] config::RigConfig load_rig_or_default(const std::optional<std::string>& rig_file);

/// Whether a local run without --rig would move a machine; true where the default rig file cannot be read.
[[nodiscard]] bool default_rig_moves_machine();

/// What became of a rig file since the service read it.
struct FileChange {
  std::string what;   ///< a clause such as "/etc/ehad/rig.toml is gone since ehad read it"
  std::string first;  ///< what to do before a reload, such as "put it back, then"; empty: nothing
};

/// Compares the rig file of a running service with what the service has read: where they differ other limits are in
/// force than a reader believes. None where they are equal, or where this user cannot read the file.
/// @param rig  of the service's status
[[nodiscard]] std::optional<FileChange> change_since_read(const nlohmann::ordered_json& rig);

/// The rig of a running service and the position of its rod.
struct ServiceRig {
  std::string file;
  std::string name;
  bool moves = false;  ///< a machine
  std::optional<double> place_in;
  std::optional<FileChange> change = {};  ///< since the service read it
  bool is_moving = false;                 ///< a run is on: where the rod will stand after it is unknown
  bool is_disarmed = false;               ///< `eha arm` comes before a motion
};

/// None if no service answers.
[[nodiscard]] std::optional<ServiceRig> rig_of_service(const std::filesystem::path& socket, const Console& console);

/// How a command reaches the rig of a running service as that is now. @param socket  the service's
[[nodiscard]] suggest::RigAccess access_of(const ServiceRig& service, const std::filesystem::path& socket);

/// `eha run` of an experiment file. A service is sent the text alone: one that names a file of volts is played in this
/// process, which is warned of; a machine's service releases the device before.
[[nodiscard]] std::string run_of(const config::ExperimentConfig& experiment, const config::RigConfig& rig,
                                 const suggest::RigAccess& access, const Console& console);

/// @throws UsageError  the service's file is not the one that it has read: other limits are in force
void require_as_read(const ServiceRig& service);

/// Warns of such a file before a motion: other limits may be in force than a reader of the file believes.
void warn_if_edited(const nlohmann::ordered_json& rig, const std::filesystem::path& socket, const Console& console);

/// Warns at arming of what a rig file that this user may read leaves without protection, and of what is no number of a
/// rig. Silent for a file that was edited since the service read it.
void warn_of_rig_file(const nlohmann::ordered_json& rig, const Console& console);

}  // namespace eha::cli
