// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

// The commands that terminal and pages suggest, whole, so that a user can paste them. Every command that reaches a rig
// is made here. Names are quoted for a shell.

namespace eha::suggest {

/// How a user reaches the rig that a suggestion is about.
struct RigAccess {
  bool is_local = false;                      ///< in the user's own process instead of through ehad
  bool is_fast = false;                       ///< in virtual time
  bool is_disarmed = false;                   ///< without is_local: `eha arm` comes before a motion
  std::string rig_file = {};                  ///< with is_local and of `eha tune`; empty: the default one
  std::string socket = {};                    ///< of the service; empty: the default one
  std::string output = {};                    ///< with is_local: parent of run folders; empty: the default one
  bool allows_non_realtime = false;           ///< with is_local
  bool accepts_travel_risk = false;           ///< of `eha run`
  std::string new_rig_file = "rig-new.toml";  ///< that a measurement of the valve writes; empty: no rig of this program
  std::string bare_rig_file = "rig-bare.toml";  ///< that a copy of the rig file without [following] is written to
  std::string controller = {};                  ///< file of the controller in question; empty: none
  std::string model = {};                       ///< file, or run, of which a controller is made; empty: none
  std::string new_controller = {};              ///< file that `eha tune` writes; empty: its default one
  std::string fit = {};                         ///< `eha fit RECORD` of the record in question; empty: none
};

/// How the run of a run.json was played, with the names in it, which are absolute. New files are named after the time
/// of the run. Without `played_by`, in runs of earlier versions, one in virtual time counts as local.
[[nodiscard]] RigAccess access_of_run(const nlohmann::ordered_json& manifest);

/// The same for texts that offer another fit of a record. @param record  a run folder or a file
[[nodiscard]] RigAccess with_fit_of(RigAccess rig, const std::string& record);

/// `eha run EXPERIMENT...`.
[[nodiscard]] std::string run(const RigAccess& rig, const std::vector<std::string>& experiments);

/// `eha characterise -o rig-new.toml`: measures the valve and writes a rig file.
[[nodiscard]] std::string characterise(const RigAccess& rig);

/// `eha characterise --without-following -o rig-bare.toml`: a copy of the rig file in use; nothing moves.
[[nodiscard]] std::string without_following(const RigAccess& rig);

/// `eha characterise RUN -o rig-new.toml`: the same numbers of a run of before.
[[nodiscard]] std::string sheet_into_rig_file(const RigAccess& rig, const std::string& run);

/// `eha read`: the rod and its sensor.
[[nodiscard]] std::string read(const RigAccess& rig);

/// `eha calibrate`: scale and offset of the sensor by a ruler.
[[nodiscard]] std::string calibrate(const RigAccess& rig);

/// `eha track CONTROLLER`: the trial of a controller.
[[nodiscard]] std::string track(const RigAccess& rig, const std::string& controller);

/// `eha tune MODEL`. @param sheet  run of a valve sheet; empty: none
[[nodiscard]] std::string tune(const RigAccess& rig, const std::string& model, const std::string& sheet = {});

/// `eha export CONTROLLER --format st`, into a file beside the present folder's others.
[[nodiscard]] std::string export_for_plc(const std::string& controller);

/// A command of the service, with its socket unless that is the default one.
[[nodiscard]] std::string through(const std::string& socket, std::string command);

/// Completes commands that a text names in short, between backticks: `eha characterise`, `eha read`, `eha calibrate`,
/// `eha track`, and "then `eha tune`" or ": `eha tune`", each as the functions above make it, a local `eha tune` with
/// the rig file that an `eha characterise` of the same text writes, and `eha fit --model NAME`, which gets the record.
/// `eha track` needs a controller, `eha tune` a model; without it the name stays.
[[nodiscard]] std::string completed(std::string_view text, const RigAccess& rig);

/// The same in HTML, where a command stands as <code>eha read</code>.
[[nodiscard]] std::string completed_html(std::string_view html, const RigAccess& rig);

}  // namespace eha::suggest
