// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "config/experiment_config.hpp"
#include "config/rig_config.hpp"
#include "core/guard_page.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/acquisition/circuits_at_rest.hpp"
#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/run.hpp"
#include "daemon/acquisition/state_machine.hpp"
#include "daemon/acquisition/status_board.hpp"
#include "daemon/acquisition/stop_request.hpp"
#include "daemon/delays/delays.hpp"
#include "daemon/play/early_end.hpp"
#include "daemon/play/run_watch.hpp"
#include "hal/rig.hpp"

namespace eha::play {

/// The program that plays a run, by its name in run.json.
enum class PlayedBy { eha, ehad };

/// One experiment on one rig.
struct PlayRequest {
  const config::RigConfig& rig;
  const config::ExperimentConfig& experiment;
  std::span<const double> table_V;            ///< one repetition, one voltage a tick [V]
  std::span<const double> predicted_in = {};  ///< with [hold]: one repetition, one displacement a tick [in]
  std::filesystem::path folder;               ///< made by record::create_run_folder
  acquisition::TimeBase time_base = acquisition::TimeBase::monotonic;
  acquisition::NonRealtime non_realtime = acquisition::NonRealtime::refuse;
  PlayedBy played_by = PlayedBy::eha;
  EarlyEnd* early_end = nullptr;  ///< none: every repetition is played
  RunWatch* watch = nullptr;      ///< none: nobody watches the run
  acquisition::EarlierRuns* earlier =
      nullptr;                ///< the runs on this rig, which this one adds to; none: it is the only one
  GuardPage* page = nullptr;  ///< shared with the rig's guard; none: a killed process costs up to 0.2 s of the record
  /// Gives the guard the journal, whose lock it shares; called once, before the rig is driven.
  std::function<void(const os::FileDescriptor& journal)> share_journal = {};
  /// Called immediately before the rig is driven. If it throws, nothing is driven and the folder is removed.
  std::function<void(hal::Rig&)> before_driven = {};
};

/// A run that has ended.
struct FinishedRun {
  std::filesystem::path folder;
  acquisition::RunReport report;   ///< outcome write_failed also if only the files after the journal failed
  std::string write_error;         ///< message of the write that failed; empty when everything was written
  bool only_placed = false;        ///< the rod was moved to a place; there is nothing to fit
  double displacement_in = 0.0;    ///< of the last reading [in]
  double velocity_in_per_s = 0.0;  ///< at that time
  std::chrono::steady_clock::time_point ended = {};  ///< when that was, before the files were written
  std::vector<delays::Delay> delays = {};            ///< causes of late ticks, if there were any
  /// What the lines of a machine showed while the files were written: unless sound, nothing may follow unasked.
  acquisition::CircuitAtRest circuit = acquisition::CircuitAtRest::sound;
};

/// Called about ten times a second in the thread that called play(). If it throws, the run is ramped out, its files are
/// written, and play() throws the same exception.
using Progress = std::function<void(const acquisition::Snapshot&)>;

/// Plays an experiment on a rig and records it in the request's run folder. Blocks until the rig is idle or faulted and
/// the files are closed: run.json, raw.ehalog, raw.h5 and data_40ms.csv. A fault, a stop or a failing disk is not
/// thrown: report.outcome says so (acquisition::describe, acquisition::exit_code), and the partial record is kept.
/// Equal requests in virtual time on equal rigs give byte-identical raw.ehalog, raw.h5 and data_40ms.csv.
/// A fatal signal while the loop runs makes the rig safe before the process dies of it (acquisition::FatalSignals).
/// The loop and the journal have a thread each, so a slow `progress` delays neither.
/// @param machine  must be armed
/// @throws ConfigError, PermissionError  as acquisition::run; the folder is removed
/// @throws IoError  the disk has too little room; the rig was not driven and the folder is removed
[[nodiscard]] FinishedRun play(hal::Rig& rig, acquisition::StateMachine& machine, const PlayRequest& request,
                               acquisition::StopRequest& stop, const Progress& progress = {});

}  // namespace eha::play
