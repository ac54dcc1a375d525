// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "daemon/batch/batch_folder.hpp"
#include "daemon/control/client.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/importer/options.hpp"
#include "ident/estimation/fit_options.hpp"
#include "ident/export/exported_model.hpp"
#include "ident/fractional/simulate.hpp"

// One struct for each command of eha(1), filled by command_line.cpp, and the function that executes it. Each returns
// the exit code of a legitimate outcome and throws eha::Error for broken input or environment.

namespace eha::cli {

/// How a command that moves a rig does so.
struct DriveOptions {
  std::optional<std::string> rig_file = {};  ///< with `local`; none: default_rig_file()
  std::filesystem::path socket = control::default_socket();
  bool local = false;                     ///< in this process
  bool fast = false;                      ///< virtual time
  bool yes = false;                       ///< move a real actuator without asking
  bool allow_non_realtime = false;        ///< run on ordinary scheduling too
  std::filesystem::path output = "runs";  ///< with `local`: where the run folder goes
};

struct RunCommand : DriveOptions {
  std::string experiment_file = {};
  std::vector<std::string> further_files = {};  ///< played after it, in order
  std::optional<std::string> text = {};         ///< of the experiment; none: experiment_file is read
  bool detach = false;                          ///< queue and leave
  bool accept_travel_risk = false;              ///< play what the rehearsal refuses
};

/// Options on the use of a record; an unset member leaves the experiment's value or the default.
struct RecordOptions {
  std::optional<int> decimation = {};
  std::optional<double> discard_s = {};
  std::optional<double> split = {};
  std::optional<double> input_before = {};
};

/// Options on the models to fit.
struct ModelOptions {
  std::vector<std::string> families = {};         ///< --model, in order; without --structure too: the experiment's
  std::vector<std::string> structure_files = {};  ///< --structure, in order
  std::optional<int> poles = {};
  std::optional<int> zeros = {};
  std::optional<std::string> delay = {};  ///< "free" or seconds
  std::optional<ident::InitialState> initial_state = {};
  std::optional<std::string> input_map = {};  ///< "none" or "valve"
  std::vector<std::string> fixed = {};        ///< NAME=VALUE
  std::vector<std::string> free = {};         ///< NAME
  std::vector<std::string> starts = {};       ///< NAME=VALUE
  std::vector<std::string> bounds = {};       ///< NAME=LOW:HIGH
};

struct FitCommand {
  std::string source;  ///< run folder or file with a record
  importer::Options import = {};
  std::optional<std::string> experiment_file = {};
  std::optional<ident::Procedure> procedure = {};
  bool compares_with_paper = false;  ///< --procedure both; `procedure` is the default one then
  std::optional<std::uint64_t> seed = {};
  RecordOptions record;
  ModelOptions models;
  std::optional<std::filesystem::path> output = {};     ///< folder for one model file per model
  bool sweep = false;                                   ///< the commensurate order over sweep_orders instead
  std::vector<double> sweep_orders = {0.5, 1.2, 0.05};  ///< first, last, step
  bool cross_validate = false;                          ///< on each repetition, scored on the others
};

struct ImportCommand {
  std::string file;
  importer::Options import = {};
  std::optional<std::filesystem::path> output = {};  ///< none: standard output
};

struct SimulateCommand {
  std::string model_file;
  std::string input_file;
  importer::Options import = {};
  std::optional<std::filesystem::path> output = {};  ///< none: standard output
  ident::SimulationMethod method = ident::SimulationMethod::exact;
};

struct ValidateCommand {
  std::string model_file;
  std::string source;  ///< run folder or file with a record
  importer::Options import = {};
  std::optional<std::string> experiment_file = {};
  RecordOptions record;
};

struct ExportCommand {
  std::string source;                                 ///< model file, run folder or record
  std::string format;                                 ///< of ident::model_formats() or record::record_formats()
  std::optional<ident::FrequencyInterval> band = {};  ///< none: the model's own
  std::optional<std::filesystem::path> output = {};   ///< none: standard output
};

struct CompareCommand {
  std::vector<std::string> sources;                  ///< run folders and records, or model files (.json)
  std::optional<std::filesystem::path> output = {};  ///< report (.html), or picture of the Bode plots
};

struct ReplayCommand {
  std::string source;                        ///< run folder or record
  std::optional<std::string> rig_file = {};  ///< none: default_rig_file()
  std::vector<std::string> calibrate = {};   ///< KEY or KEY=LOW:HIGH
  std::filesystem::path twin = "twin.toml";  ///< written when something is calibrated
  std::optional<std::filesystem::path> output = {};
};

struct ReportCommand {
  std::vector<std::string> sources;                  ///< one run folder, or model files
  std::optional<std::filesystem::path> output = {};  ///< none: report.html, in the run folder of a run
};

struct StudyCommand {
  int seeds = 10;  ///< records of each kind of plant
  std::filesystem::path output = "study-paper";
};

struct PlotCommand {
  std::string source;                                ///< run folder, CSV file or model file
  std::optional<std::filesystem::path> output = {};  ///< none: in characters on standard output
};

struct BatchCommand {
  std::vector<std::string> sources;  ///< run folders, files, folders of them, lists
  std::filesystem::path output = "batch";
  std::optional<std::size_t> jobs = {};  ///< none: the processors
  batch::Shard shard = {};
  std::vector<std::string> fit_options = {};  ///< of `eha fit`, what follows --
};

struct BatchMergeCommand {
  std::vector<std::filesystem::path> folders;
  std::optional<std::filesystem::path> output = {};  ///< none: the first folder
};

struct CheckCommand {
  std::string file;
  std::optional<std::string> rig_file = {};
  std::optional<std::string> place = {};  ///< length with its unit: where the rod stands
  bool accept_travel_risk = false;        ///< warn only of what the rehearsal refuses
};

struct DesignCommand {
  std::optional<std::string> experiment_file = {};  ///< none: with `model_file` alone
  std::optional<std::string> rig_file = {};
  std::optional<std::filesystem::path> output = {};
  std::optional<std::string> model_file = {};  ///< --from: writes the experiment that improves this model
  std::string parameter = {};                  ///< --improve
  std::optional<double> wanted_std = {};       ///< --to
  std::optional<std::string> twin_file = {};   ///< --twin: simulated rig that predicts; none: the rig if simulated
  std::optional<ident::FrequencyInterval> band = {};  ///< --band: writes an experiment of equal tones in this band
  int tones = 30;
  double period_s = 20.0;                ///< of the tones
  std::optional<int> realisations = {};  ///< --odd-random: of an odd-random multisine in the band; none: tones
};

struct RunsListCommand {
  std::optional<std::filesystem::path> folder = {};  ///< none: "runs", or the service's where that is not there
  std::optional<std::filesystem::path> socket = {};  ///< ask this service
};

struct RunsShowCommand {
  std::filesystem::path run;
};

struct RunsRecoverCommand {
  std::filesystem::path target;  ///< one run folder, or a folder of them
};

struct DoctorCommand {
  std::optional<std::string> rig_file = {};             ///< none: default_rig_file()
  std::filesystem::path output = "runs";                ///< where run folders would go
  std::optional<std::filesystem::path> following = {};  ///< run that [following] is learnt from; none: checks
};

struct LatencyCommand {
  double duration_s = 60.0;
  bool load = false;  ///< keep every CPU busy meanwhile
  std::optional<std::string> rig_file =
      {};  ///< whose period, priority and CPU the loop takes; none: default_rig_file()
};

/// `eha goto` and `eha jog`: a run whose experiment only moves the rod to a place.
struct PlaceCommand : DriveOptions {
  std::string where = {};    ///< a length with its unit
  bool is_relative = false;  ///< to where the rod is
};

struct CharacteriseCommand : DriveOptions {
  std::optional<std::string> run = {};  ///< shows the sheet of this run; nothing moves
};

struct CalibrateCommand {
  std::vector<std::string> at = {};                  ///< POSITION=VOLTS
  std::optional<std::string> pairs_file = {};        ///< CSV: position_in, voltage_V
  std::optional<std::filesystem::path> socket = {};  ///< none: the default one, or the rig where nobody listens
  std::optional<std::string> rig_file = {};          ///< none: the service's, or default_rig_file()
  bool local = false;                                ///< read the rig in this process
  double tolerance_in = 0.02;                        ///< a residual beyond it is warned of
  std::optional<std::filesystem::path> output = {};  ///< none: beside the rig file, with the date in its name
};

struct ReadCommand {
  std::optional<std::filesystem::path> socket = {};  ///< none: the default one, or the rig itself where nobody listens
  std::optional<std::string> rig_file = {};          ///< with `local`; none: default_rig_file()
  bool local = false;                                ///< read the rig in this process
  bool watch = false;                                ///< repeatedly
};

/// A method of ehad-protocol(7): status, arm, disarm, stop, metrics, reload, queue, hold, release, move, cancel, ack,
/// remove.
struct ServiceCommand {
  std::string method;
  std::filesystem::path socket = control::default_socket();
  std::vector<std::int64_t> entries = {};  ///< of cancel, hold, release and move; none: every one of the user's
  std::int64_t to = 0;                     ///< of move: position from 1; 0: `by` says
  std::int64_t by = 0;                     ///< of move: positions towards the end
  std::string run = {};                    ///< of ack and remove: its folder or the folder's name
  bool yes = false;                        ///< of remove: without asking
  bool watch = false;                      ///< of status: repeatedly
};

/// Becomes eha-web.
struct WebCommand {
  std::uint16_t port = 8420;  ///< on 127.0.0.1; 0: any free one
  std::filesystem::path socket = control::default_socket();
  std::optional<std::string> runs = {};        ///< folder; none: the one that ehad names
  std::optional<std::string> token_file = {};  ///< none: a token for the process is made and printed
  std::vector<std::string> allowed_hosts = {};
};

using Command = std::variant<RunCommand, FitCommand, ImportCommand, SimulateCommand, ValidateCommand, ExportCommand,
                             CompareCommand, ReplayCommand, ReportCommand, PlotCommand, BatchCommand, BatchMergeCommand,
                             CheckCommand, DesignCommand, RunsListCommand, RunsShowCommand, RunsRecoverCommand,
                             DoctorCommand, LatencyCommand, PlaceCommand, CharacteriseCommand, CalibrateCommand,
                             ReadCommand, StudyCommand, ServiceCommand, WebCommand>;

[[nodiscard]] ExitCode execute(const RunCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const FitCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ImportCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const SimulateCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ValidateCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ExportCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const CompareCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ReplayCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ReportCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const PlotCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const BatchCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const BatchMergeCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const CheckCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const DesignCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const RunsListCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const RunsShowCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const RunsRecoverCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const DoctorCommand& command, Console& console);
/// `eha doctor --following RUN`. @throws DataError  the run holds too little   @throws IoError, PermissionError
[[nodiscard]] ExitCode learn_following(const std::filesystem::path& folder, Console& console);
[[nodiscard]] ExitCode execute(const LatencyCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const PlaceCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const CharacteriseCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const CalibrateCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ReadCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const StudyCommand& command, Console& console);
[[nodiscard]] ExitCode execute(const ServiceCommand& command, Console& console);
/// Returns only on an error. @throws ConfigError, IoError
[[nodiscard]] ExitCode execute(const WebCommand& command, Console& console);

}  // namespace eha::cli
