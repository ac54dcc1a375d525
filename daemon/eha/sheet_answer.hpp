// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "core/error.hpp"
#include "daemon/control/socket_path.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/record/open_run.hpp"

namespace eha::cli {

/// Whether valve_sheet.json and report.html can be written into the run folder, or exist there.
enum class SheetFiles { write, keep };

/// A rig file to write with the sheet's numbers.
struct NewRigFile {
  std::filesystem::path path;  ///< must not exist yet
  std::string replaces = {};   ///< the rig file that the service uses; empty: no service
  std::string completes = {};  ///< without a service: the rig file in use; empty: that of the run
  std::filesystem::path socket = control::default_socket();  ///< of that service
  bool is_named = false;                                     ///< `completes` is what the user asked for
};

/// Computes the valve sheet of a completed run of [characterise] and prints it with the lines for rig and experiment
/// files.
/// @param rig_file  none: none is written
/// @throws UsageError  the new rig file already exists; DataError, IoError, PermissionError  as sheet::sheet_of_run;
///                     the folder cannot be written
ExitCode show_valve_sheet(const record::OpenRun& opened, SheetFiles files, std::optional<NewRigFile> rig_file,
                          const Console& console);

}  // namespace eha::cli
