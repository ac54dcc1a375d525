// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "hal/rig.hpp"

namespace eha::record {

/// Which clock a run is kept by.
enum class TimeBase : std::uint8_t {
  monotonic,     ///< the real one, one tick each sample period
  virtual_time,  ///< as fast as the machine computes; only for rigs that allow it
};

/// One experiment on one rig.
struct RunRequest {
  std::filesystem::path runs_folder;  ///< where the run folder is created
  const config::RigConfig& rig;
  const config::ExperimentConfig& experiment;
  std::span<const double> table_V;  ///< one repetition, one voltage a tick [V]
  TimeBase time_base = TimeBase::monotonic;
  acquisition::NonRealtime non_realtime = acquisition::NonRealtime::refuse;
};

/// What a run left behind.
struct FinishedRun {
  std::filesystem::path folder;
  acquisition::RunReport report;  ///< outcome write_failed also when only the files after the journal failed
  std::string write_error;        ///< what the writer could not do; empty when all was written
};

/// Called some ten times a second, in the thread that called run_experiment. When it throws, the run is stopped as by a
/// stop request, its files are written, and run_experiment throws the same.
using Progress = std::function<void(const acquisition::Snapshot&)>;

/// Runs an experiment on a rig into a new run folder and blocks until the rig is idle or faulted and the files are
/// closed: run.json, raw.ehalog, raw.h5, data_40ms.csv and an empty models folder. A fault, a stop or a failing disk
/// is no exception: report.outcome says so (acquisition::describe, acquisition::exit_code) and what was recorded is
/// kept. Equal requests in virtual time on equal rigs give byte-identical raw.ehalog, raw.h5 and data_40ms.csv.
/// A fatal signal while the loop runs makes the rig safe before the process dies of it (acquisition::FatalSignals).
/// The writer has a thread of its own, so a slow `progress` delays nothing but itself.
/// @param machine  must be armed
/// @throws ConfigError, PermissionError  as acquisition::run; no folder is left behind
/// @throws IoError  the folder cannot be created or the disk has too little room; the rig was not touched
[[nodiscard]] FinishedRun run_experiment(hal::Rig& rig, acquisition::StateMachine& machine, const RunRequest& request,
                                         acquisition::StopRequest& stop, const Progress& progress = {});

}  // namespace eha::record
