// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/free_name.hpp"
#include "core/shell_word.hpp"
#include "daemon/suggest/commands.hpp"
#include "ident/validation/first_step.hpp"

namespace eha::config {
struct RigConfig;
}

namespace eha::cli {

struct DriveOptions;
struct Trip;
struct RunCommand;

/// Adds --socket to a command for the service that the user has just used, unless it is the default one.
[[nodiscard]] std::string through(const std::filesystem::path& socket, std::string command);

/// What follows once a rig file is in force: the rig is armed, or the sensor read, before anything moves.
enum class InForce { arm, read };

/// The commands that put a new rig file, once it is checked, in the place of a service's and have it read; with sudo
/// where this user cannot write that file.
[[nodiscard]] std::string put_in_force(const std::filesystem::path& made, const std::filesystem::path& of_service,
                                       const std::filesystem::path& socket, InForce then = InForce::arm);

/// How a command of this user reaches the rig: with its options, but not --yes, so that the user is asked again. New
/// files have names that are not taken.
[[nodiscard]] suggest::RigAccess access_of(const DriveOptions& drive);
[[nodiscard]] suggest::RigAccess access_of(const RunCommand& run);

/// The simulated rig of this process; `eha run EXPERIMENT --local --fast` on this rig file.
[[nodiscard]] suggest::RigAccess simulated_access(const std::optional<std::string>& rig_file);

/// How the rig of a rig file is reached: one that moves a machine through its service, a simulated one in this process.
/// @param named  the file as the user named it; none: the default one
[[nodiscard]] suggest::RigAccess access_of_rig(const config::RigConfig& rig, const std::optional<std::string>& named);

/// simulated_access() where no rig was named: through the service, or where there is none and the default rig is a
/// simulated one, in this process.
[[nodiscard]] suggest::RigAccess usual_access();

/// The access to the rig of a record that no run of `eha` made: that of a service. A simulated rig has another valve,
/// and whether this program drives the rig of the file is not known: its valve is measured by a record on the bench.
[[nodiscard]] suggest::RigAccess access_of_file();

/// An experiment to begin with: the shipped one. Without it a name to be replaced.
[[nodiscard]] std::string an_experiment();

/// How the run in a folder was played, as far as run.json says, from the present folder.
/// @param asked_service  whether a service has the run
[[nodiscard]] suggest::RigAccess access_of_run(const std::filesystem::path& folder, bool asked_service = false);

/// A name of a rig file for --rig: relative to the present folder if it is below; empty for the default one and for a
/// file that is not there.
[[nodiscard]] std::string rig_name(const std::filesystem::path& file);

/// The words of a file that `eha simulate` takes as an input: a record's own, or the thinned rows in a run's folder
/// with the option that takes them as such. Nothing for a record that is not there or needs an option. Reads the
/// record. @param unit  of the model's input
[[nodiscard]] std::optional<std::string> input_words_of_record(const std::string& record, const std::string& unit);

/// Returns the command that opens the report of a run; `otherwise` if it has none.
[[nodiscard]] std::string report_of_run(const std::filesystem::path& folder, const std::string& otherwise);

/// The name of the fault that a description of a run's end begins with.
[[nodiscard]] std::string_view fault_name(std::string_view description);

/// Returns the command that looks for the cause of a placing's or a valve sheet's trip: `eha read`, which shows whether
/// the sensor follows the rod. A simulated rig has sound hydraulics, valve and wires: if its rod does not move as
/// [following] says, the copy of its file without it, whose Next measures the valve; `eha characterise` begins with
/// such a placing, and would trip like it. A trip at a limit of the travel is for `eha read`.
/// @param of_run       the rig that it moved; null: not known
[[nodiscard]] std::string next_after_trip(const Trip& trip, const config::RigConfig* of_run,
                                          const suggest::RigAccess& rig);

/// Refuses to begin work whose result goes into a run folder that the caller may not write, as one of the service.
/// @param command  "eha fit RUN", to which the refusal adds an output of its own   @param output  the name of that
/// @throws PermissionError
void require_writable_run(const std::filesystem::path& folder, const std::string& command, const std::string& output);

/// `eha fit RUN`; nothing for a record that is too short to fit, as one that ends within the discarded time, whose
/// start alone judges no model, or has no rows to fit. Reads the record.
[[nodiscard]] std::optional<std::string> fit_of_run(const std::filesystem::path& folder);

/// Whether a run has a row that can be read. False for a folder that this user may not read.
[[nodiscard]] bool has_rows(const std::filesystem::path& folder);

/// "the partial record is in RUN; `eha fit RUN` fits it", or the reason why it cannot be fitted.
[[nodiscard]] std::string partial_record_text(const std::filesystem::path& folder);

/// The same for a run with nothing to fit, a placing or a characterisation: `eha plot RUN` shows it.
[[nodiscard]] std::string kept_record_text(const std::filesystem::path& folder);

/// Returns the file of a run's recommended model; nothing if it recommends none. @param folder  a run's
[[nodiscard]] std::optional<std::filesystem::path> recommended_model(const std::filesystem::path& folder);

/// Why a run without a recommended model has none, and what gives one.
[[nodiscard]] std::string why_no_model(const std::filesystem::path& folder);

/// What ident::next_step() names first of a run's models; none where the caller may not read them.
[[nodiscard]] ident::NextStep first_of_run(const std::filesystem::path& folder);

/// `eha fit RUN --to 38.64`, the part of a run that ident::next_step() keeps; none where it cuts nothing.
[[nodiscard]] std::optional<std::string> cut_of_run(const std::filesystem::path& folder);

/// `eha tune RUN`, with the newest valve sheet of the same rig beside that run; nothing if the run recommends no model.
[[nodiscard]] std::optional<std::string> tune_of_run(const std::filesystem::path& folder,
                                                     const suggest::RigAccess& rig);

/// `eha tune MODEL` with the same sheet, for a model of that run's record.
[[nodiscard]] std::string tune_of_model(const std::filesystem::path& model, const std::filesystem::path& run,
                                        const suggest::RigAccess& rig);

}  // namespace eha::cli
