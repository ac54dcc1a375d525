// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/following_warning.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>
#include <vector>

#include "config/measured_check.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_header.hpp"
#include "daemon/record/sheet_beside.hpp"
#include "daemon/report/display.hpp"
#include "daemon/report/sheet_comparison.hpp"
#include "ident/model/model_file.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/valve/supply.hpp"

namespace eha::cli {

namespace fs = std::filesystem;

namespace {

/// Returns the rig file of a run; none without [following], or in a record without a rig file.
std::optional<config::RigConfig> known_rig_of(const fs::path& run) {
  const nlohmann::ordered_json other = record::read_manifest(run).other;
  const nlohmann::ordered_json::json_pointer text("/rig/text");
  if (!other.contains(text)) return std::nullopt;
  config::RigConfig rig =
      config::parse_rig(other.at(text).get<std::string>(), fmt::format("the rig file of {}", run.string()));
  if (!rig.limits.following) return std::nullopt;
  return rig;
}

static_assert(ident::kNotedShift_V <= config::kSameValve_V, "a shift that explains a difference has its note");

}  // namespace

bool warn_of_leak(const fs::path& run, const Console& console, const std::string& units) {
  const auto leak = record::leak_beside(run);
  if (leak) console.warning(ident::leak_finding(*leak, console.unit(units)));
  return leak.has_value();
}

std::optional<FoundValve> valve_of_sheet(const fs::path& run, const suggest::RigAccess& rig) {
  const auto sheet = record::valve_in(run);
  if (!sheet) return std::nullopt;
  return FoundValve{.map = {.zone = sheet->zone},
                    .gains = sheet->gains,
                    .source = fmt::format("the valve sheet of {}", run.string()),
                    .remedy = suggest::sheet_into_rig_file(rig, run.string())};
}

bool is_of_one_valve(const ident::Model& model, const FoundValve& sheet) {
  return tune::is_of_one_valve(sheet.map.zone, tune::found_map(model));
}

FoundValve valve_of_model(const ident::Model& model, const std::string& name, const std::optional<FoundValve>& sheet,
                          const suggest::RigAccess& rig) {
  return {.map = tune::found_map(model),
          .source = name,
          .remedy = sheet && is_of_one_valve(model, *sheet) ? sheet->remedy : suggest::characterise(rig),
          .note = ident::map_note(model)};
}

namespace {

/// Whether the newest sheet beside a run has the null and dead band of a model, so that its map is not off the valve's.
bool sheet_confirms(const ident::Model& model, const fs::path& run) {
  if (run.empty() || !model.input_map) return false;
  try {
    const auto sheet_run = record::newest_sheet_run(run);
    const auto sheet = sheet_run ? valve_of_sheet(*sheet_run) : std::nullopt;
    return sheet && config::is_of_one_valve(sheet->map.zone, tune::found_map(model).zone);
  } catch (const Error&) {  // a folder that the caller may not read
    return false;
  }
}

}  // namespace

void say_map_note(const ident::Model& model, const fs::path& run, const Console& console) {
  if (sheet_confirms(model, run)) return;
  const auto sheet = run.empty() ? ident::SheetSays::nothing : record::sheet_says_beside(run);
  if (const std::string note = ident::map_note(model, sheet); !note.empty()) {
    console.warning(fmt::format("of {}: {}", model.name, note));
  }
}

namespace {

/// Null and dead band of [following] agree with the found valve. @returns whether its numbers are for the rig file
bool warn_if_gains_differ(const config::RigConfig& rig, const FoundValve& found, const Console& console) {
  constexpr double kSameGain = 1.2;
  if (!found.gains) return false;
  const config::ValveEstimate known = config::valve_estimate(*rig.limits.following);
  const double positive = found.gains->first / known.gain_positive_in_per_V_s;
  const double negative = found.gains->second / known.gain_negative_in_per_V_s;
  const auto differs = [](double ratio) { return std::max(ratio, 1.0 / ratio) > kSameGain; };
  if (!differs(positive) && !differs(negative)) return false;
  const DisplayUnit unit = console.unit(rig.units);
  const double factor = unit.factor("in");
  const std::string what =
      fmt::format("[following] of {} is for gains of {:.3g} and {:.3g} {}/(V s); after {} they are {:.3g} and {:.3g}",
                  rig.file_name, factor * known.gain_positive_in_per_V_s, factor * known.gain_negative_in_per_V_s,
                  unit.of("in"), found.source, factor * found.gains->first, factor * found.gains->second);
  const bool is_alike = ident::common_gain_factor(positive, negative).has_value();
  if (is_alike && config::is_as_measured(rig)) {  // its numbers would make a weak supply the usual one
    console.warning(fmt::format("{}: {}", what, ident::kSupplyFirst));
    return false;
  }
  console.warning(fmt::format("{}{}; `{}` writes the rig file with measured numbers", what,
                              is_alike ? fmt::format(". If the file's were right once, {}", ident::kSupplyFirst) : "",
                              found.remedy));
  return true;
}

}  // namespace

bool warn_if_following_differs(const config::RigConfig& rig, const FoundValve& found, const Console& console) {
  if (!rig.limits.following) {
    if (!found.note.empty()) console.warning(fmt::format("of {}: {}", found.source, found.note));
    return false;
  }
  const config::ValveEstimate known = config::valve_estimate(*rig.limits.following);
  const tune::FollowingAgreement agreement = tune::agreement_of(*rig.limits.following, found.map);
  if (agreement == tune::FollowingAgreement::one_valve && warn_if_gains_differ(rig, found, console)) return true;
  if (agreement == tune::FollowingAgreement::one_valve) return false;        // whatever the map may be off
  if (agreement == tune::FollowingAgreement::within_interval) return false;  // the record knows less than the file
  if (agreement == tune::FollowingAgreement::within_map_error) {
    console.info(fmt::format(
        "null {:.3f} V and half dead band {:.3f} V of {} are not the valve's{}. [following] of {} (null_V = {:.3f}, "
        "and dead_band_V = {:.3f} with {:.2f} V to spare) does not contradict the record; keep it, or measure: `{}`",
        found.map.zone.null_V, found.map.zone.dead_band_V, found.source, found.note.empty() ? "" : ": " + found.note,
        rig.file_name, known.null_V, rig.limits.following->dead_band_V, config::kDeadBandSpare_V, found.remedy));
    return false;
  }
  console.warning(fmt::format(
      "[following] of {} has null_V = {:.3f} and dead_band_V = {:.3f}; after {} they are {:.3f} and {:.3f} ({:.3f} and "
      "{:.2f} to spare): goto, "
      "rehearsals and the following check are for another valve; `{}` writes the rig file with measured numbers",
      rig.file_name, known.null_V, rig.limits.following->dead_band_V, found.source, found.map.zone.null_V,
      found.map.zone.dead_band_V + config::kDeadBandSpare_V, found.map.zone.dead_band_V, config::kDeadBandSpare_V,
      found.remedy));
  return true;
}

std::optional<std::string> warn_of_unused_sheet(const fs::path& run, const Console& console) {
  try {
    const auto sheet_run = record::newest_sheet_run(run);
    const auto rig = known_rig_of(run);
    if (!sheet_run || !rig) return std::nullopt;
    const auto sheet = valve_of_sheet(*sheet_run, console.rig());
    // Of a leak that the sheet shows is said what to do, which is another thing.
    if (record::leak_in(*sheet_run)) return std::nullopt;
    if (sheet && warn_if_following_differs(*rig, *sheet, console)) return sheet->remedy;
  } catch (const Error& error) {  // a folder that the caller may not read
    console.debug(error.what());
  }
  return std::nullopt;
}

ValveNow warn_of_changed_valve(const fs::path& run, const Console& console) {
  if (warn_of_leak(run, console, record::rig_units(record::read_manifest(run).other))) return ValveNow::leaks;
  const auto file = recommended_model(run);
  if (!file) return ValveNow::as_known;
  const ident::Model model = ident::model_from_text(os::read_file(*file), file->string());
  say_map_note(model, run, console);
  const auto rig = model.input_map ? known_rig_of(run) : std::nullopt;
  if (!rig) return ValveNow::as_known;
  const auto sheet_run = record::newest_sheet_run(run);
  const auto sheet = sheet_run ? valve_of_sheet(*sheet_run, console.rig()) : std::nullopt;
  FoundValve found = valve_of_model(model, "this record's model", sheet, console.rig());
  found.note.clear();  // is said already
  const bool is_another = warn_if_following_differs(*rig, found, console);
  const DisplayUnit unit = console.unit(rig->units);
  const auto beside =
      report::compare_with_sheet(report::in_unit(report::load_run(run), unit), ident::in_unit(model, unit));
  const bool has_changed = beside && !beside->headline.empty();
  if (has_changed) {
    // What to do is said already where null or dead band differ.
    const std::string to_do = " " + beside->to_do.substr(0, beside->to_do.find_last_not_of(' ') + 1);
    console.warning(beside->headline + (is_another ? "" : to_do));
  }
  const bool is_measured_since = sheet && is_of_one_valve(model, *sheet);
  const bool is_in_doubt = ident::map_shift(model) && !sheet_run;  // `eha tune` does not take such a map
  return ((has_changed || is_another) && !is_measured_since) || is_in_doubt ? ValveNow::changed : ValveNow::as_known;
}

}  // namespace eha::cli
