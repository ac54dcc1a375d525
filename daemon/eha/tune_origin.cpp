// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/tune_origin.hpp"

#include <fmt/format.h>

#include <string>
#include <system_error>

#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "daemon/eha/command.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/eha/rig_source.hpp"
#include "daemon/eha/tune_command.hpp"
#include "daemon/eha/tuned_rig.hpp"
#include "daemon/record/resolved_path.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/tune/following_agreement.hpp"
#include "daemon/tune/tune_inputs.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

std::optional<fs::path> run_of(const TuneCommand& command, const ident::Model& model) {
  std::error_code ignored;
  fs::path folder = fs::canonical(command.model_file, ignored).parent_path();
  for (int level = 0; level < 3 && folder.has_relative_path(); ++level, folder = folder.parent_path()) {
    if (record::is_run_folder(folder)) return folder;
  }
  if (std::string record = record_of(model); record::is_run_folder(record)) return record;
  return std::nullopt;
}

std::optional<ident::Leak> leak_of(const TuneCommand& command, const ident::Model& model) {
  if (command.sheet_run) return record::leak_in(*command.sheet_run);
  const std::optional<fs::path> run = run_of(command, model);
  return run ? record::leak_beside(*run) : std::nullopt;
}

fs::path rig_path(const TuneCommand& command, const ident::Model& model, const Console& console) {
  if (command.rig_file) return *command.rig_file;
  const std::optional<fs::path> run = run_of(command, model);
  if (!run) return load_rig_or_default(std::nullopt).file_name;
  try {
    const config::RigConfig before = rig_of(*run);
    const config::RigConfig now = load_rig_or_default(rig_file_of(*run));
    if (!is_one_rig(before, now) || before.text == now.text) return *run;
    console.info(fmt::format("the limits are those of {} as it is now, not those of {}; --rig names another file",
                             now.file_name, run->string()));
    return now.file_name;
  } catch (const Error& error) {
    console.debug(error.what());
    return *run;
  }
}

std::string named_record(const std::map<std::string, std::string>& provenance) {
  const auto record = provenance.find("record");
  if (record == provenance.end() || record->second.empty()) return "unknown";
  std::error_code ignored;
  if (!fs::exists(record->second, ignored)) return record->second;
  // The name is of the folder of the fit; a file of that name here may be another one.
  const auto hash = provenance.find("record_sha256");
  const bool is_file = fs::is_regular_file(record->second, ignored);
  const bool is_other = is_file && (hash == provenance.end() || record::sha256_of_file(record->second) != hash->second);
  return is_other ? record->second : record::resolved_path(record->second).string();
}

std::string changed_since_run(const TuneCommand& command, const ident::Model& model) {
  const std::optional<fs::path> run = run_of(command, model);
  const std::optional<std::string> file = !run || command.rig_file ? command.rig_file : rig_file_of(*run);
  if (!run || !file) return {};
  try {
    const config::RigConfig before = rig_of(*run);
    const config::RigConfig now = config::load_rig(*file);
    if (before.name != now.name || before.backend.index() != now.backend.index()) return {};
    const auto zone_of = [](const config::Following& following) {
      const config::ValveEstimate valve = config::valve_estimate(following);
      return config::DeadZone{valve.null_V, valve.dead_band_V};
    };
    const auto& following = now.limits.following;
    const bool is_other_valve = following && before.limits.following && !command.sheet_run &&
                                !config::is_of_one_valve(zone_of(*before.limits.following), zone_of(*following)) &&
                                (!model.input_map || tune::agreement_of(*following, tune::found_map(model)) ==
                                                         tune::FollowingAgreement::other_valve);
    std::string what;
    if (is_other_valve) {
      what = fmt::format("[following] of {} is of another valve now (null {:.3f} V, half dead band {:.3f} V)", *file,
                         zone_of(*following).null_V, zone_of(*following).dead_band_V);
    } else if (!command.rig_file && !is_one_rig(before, now)) {
      what = fmt::format("{} has other numbers in [sim] now", *file);
    } else {
      return {};
    }
    return fmt::format(
        "{} than when {} was played: model and promise are of the rig as it was then. Play the experiment again (`eha "
        "run EXPERIMENT`), then `eha tune NEWRUN`.",
        what, run->string());
  } catch (const Error&) {  // said elsewhere, or the file is gone
    return {};
  }
}

std::string why_not_of(const TuneCommand& command, const ident::Model& model, const config::RigConfig& rig) {
  const std::optional<fs::path> run = run_of(command, model);
  if (!run) return "its record is of no run";
  try {
    const config::RigConfig before = rig_of(*run);
    if (is_one_rig(before, rig)) return "";
    return before.name == rig.name
               ? fmt::format("its run {} was on a simulated rig with other numbers in [sim]", run->string())
               : fmt::format("its run {} was on another rig, \"{}\"", run->string(), before.name);
  } catch (const Error& error) {
    return fmt::format("the rig of its run cannot be read: {}", error.what());
  }
}

}  // namespace eha::cli
