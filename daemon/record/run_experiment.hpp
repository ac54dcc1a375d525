// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
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

/// What goes on inside run_experiment, for a watchdog and for those who look on. Thread-safe to read at any time.
struct RunWatch {
  enum class Phase : std::uint8_t {
    preparing,  ///< the rig is not touched yet
    playing,    ///< ticks are made: the board moves on, and so does the writer
    draining,   ///< the loop has ended, the writer has not
    closing,    ///< the files are made from the journal; takes as long as the record is long
  };
  acquisition::StatusBoard board;
  std::atomic<Phase> phase{Phase::preparing};
  std::atomic<std::uint64_t> writer_turns{0};  ///< moves on while the writer does not hang in a call on the disk
};

/// The writer may hang for so long; then the command is ramped out and the run has failed. On the monotonic clock only.
inline constexpr std::chrono::seconds kWriterPatience{6};

/// One experiment on one rig.
struct RunRequest {
  std::filesystem::path runs_folder;  ///< where the run folder is created
  const config::RigConfig& rig;
  const config::ExperimentConfig& experiment;
  std::span<const double> table_V;  ///< one repetition, one voltage a tick [V]
  TimeBase time_base = TimeBase::monotonic;
  acquisition::NonRealtime non_realtime = acquisition::NonRealtime::refuse;
  std::filesystem::path folder = {};  ///< already made by create_run_folder, instead of a new one in runs_folder
  RunWatch* watch = nullptr;
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
/// The writer has a thread of its own, so a slow `progress` delays nothing but itself and the look at the writer.
/// @param machine  must be armed
/// @throws ConfigError, PermissionError  as acquisition::run; no folder is left behind
/// @throws IoError  the folder cannot be created or the disk has too little room; the rig was not touched
[[nodiscard]] FinishedRun run_experiment(hal::Rig& rig, acquisition::StateMachine& machine, const RunRequest& request,
                                         acquisition::StopRequest& stop, const Progress& progress = {});

}  // namespace eha::record
