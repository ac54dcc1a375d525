// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/sheet/run_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <span>

#include "config/characterisation.hpp"
#include "config/experiment_config.hpp"
#include "config/measured_check.hpp"
#include "config/start_section.hpp"
#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/sha256.hpp"
#include "ident/valve/supply.hpp"

namespace eha::sheet {

RunSheet sheet_of_run(const std::filesystem::path& folder) { return sheet_of_run(record::OpenRun(folder)); }

RunSheet sheet_of_run(const record::OpenRun& opened, SheetRuns runs) {
  const record::LoadedRun run = record::read_run(opened);
  const std::filesystem::path& folder = run.folder;
  if (!config::parse_experiment(run.experiment_text, (run.folder / "run.json (experiment)").string()).characterises()) {
    throw DataError(fmt::format("{}: is no run of [characterise]; `eha characterise` plays one", folder.string()));
  }
  const bool is_cut = runs == SheetRuns::cut_as_well && run.outcome == acquisition::Outcome::deadline;
  if (run.outcome != acquisition::Outcome::completed && !is_cut) {
    throw DataError(
        fmt::format("{}: {}; a valve sheet needs a completed run", folder.string(), acquisition::to_text(run.outcome)));
  }
  const auto rows = static_cast<double>(run.record.output.size());
  const double lost_percent = 100.0 * static_cast<double>(run.record.unmeasured.size()) / rows;
  if (lost_percent > config::kMostLostRows_percent) {
    throw RowsMissing(fmt::format(
        "{}: no valve sheet: {} of {} rows ({:.4g} %) were not measured, at most {:g} % may be: the computer did "
        "not keep the ticks, or the sensor did not deliver. Repeat the run {}; if "
        "rows are lost again, `eha doctor` and `eha latency` say what keeps it busy",
        folder.string(), run.record.unmeasured.size(), run.record.output.size(), lost_percent,
        config::kMostLostRows_percent,
        run.manifest.other.contains(nlohmann::ordered_json::json_pointer("/rig/sim"))
            ? "with --fast, which no load of the computer disturbs"
            : "when the computer does nothing else"));
  }
  RunSheet found{.folder = run.folder,
                 .opened = run.opened,
                 .rig = config::parse_rig(run.rig_text, (run.folder / "run.json (rig)").string()),
                 .utc_start = {},
                 .sheet = {}};
  found.access = suggest::access_of_run(run.manifest.other);
  found.utc_start = run.manifest.other.value("utc_start", "");
  found.rig_file = run.manifest.other.value(nlohmann::ordered_json::json_pointer("/rig/file"), std::string());
  found.rig_sha256 = record::sha256_of(std::as_bytes(std::span(run.rig_text)));
  if (is_cut) found.cut_at_s = static_cast<double>(run.record.output.size()) * run.record.step_s;
  found.sheet = ident::valve_sheet(run.record, config::characterisation_plan(found.rig));
  return found;
}

config::Following following_of(const RunSheet& run) {
  const ident::ValveSheet& sheet = run.sheet;
  config::Following following = run.rig.limits.following.value_or(config::Following{});
  following.gain_positive_in_per_V_s = 0.5 * sheet.gain_positive_in_per_V_s.value;
  following.gain_negative_in_per_V_s = 0.5 * sheet.gain_negative_in_per_V_s.value;
  following.null_V = sheet.null_V.value;
  following.dead_band_V = std::max(0.0, sheet.dead_band_V.value) + config::kDeadBandSpare_V;
  following.null_uncertainty_V = sheet.null_V.half_width;
  following.dead_band_uncertainty_V = sheet.dead_band_V.half_width;
  following.gain_uncertainty_percent =
      100.0 * std::max(sheet.gain_positive_in_per_V_s.half_width / sheet.gain_positive_in_per_V_s.value,
                       sheet.gain_negative_in_per_V_s.half_width / sheet.gain_negative_in_per_V_s.value);
  following.measured_rig_check = config::measured_rig_check_of(run.rig.backend);
  return following;
}

std::string rig_lines(const RunSheet& run) {
  const config::Following following = following_of(run);
  const bool is_metric = run.rig.units == "mm";
  const char* in = is_metric ? "mm" : "in";
  const double factor = is_metric ? kMillimetresPerInch : 1.0;
  config::Following read = following;  // as the file will be read
  const auto written = [](std::string text, double unit, double& number) {
    number = std::strtod(text.c_str(), nullptr) / unit;
    return text;
  };
  const auto with_four_decimals = [&](double value, double& number) {
    return written(fmt::format("{:.4f}", value), 1.0, number);
  };
  const std::string positive = written(fmt::format("{:.4g}", factor * following.gain_positive_in_per_V_s), factor,
                                       read.gain_positive_in_per_V_s);
  const std::string negative = written(fmt::format("{:.4g}", factor * following.gain_negative_in_per_V_s), factor,
                                       read.gain_negative_in_per_V_s);
  const std::string null = with_four_decimals(following.null_V, read.null_V);
  const std::string dead_band = with_four_decimals(following.dead_band_V, read.dead_band_V);
  const std::string null_slack = with_four_decimals(*following.null_uncertainty_V, *read.null_uncertainty_V);
  const std::string dead_band_slack =
      with_four_decimals(*following.dead_band_uncertainty_V, *read.dead_band_uncertainty_V);
  const std::string gain_slack =
      written(fmt::format("{:.2f}", *following.gain_uncertainty_percent), 1.0, *read.gain_uncertainty_percent);
  return fmt::format(
      "[following]\n"
      "# Half of the measured gains: a rod that moves slower counts as stuck.\n"
      "gain_positive_{0}_per_V_s = {1}  # half of the measured {2:.4g}\n"
      "gain_negative_{0}_per_V_s = {3}  # half of the measured {4:.4g}\n"
      "null_V = {5}\n"
      "dead_band_V = {6}  # measured {7:.4f}, and {8:g} for what varies\n"
      "limit_{0} = {9:g}\n"
      "pressure_delay_s = {10:g}\n"
      "null_uncertainty_V = {11}  # of 95 %, as the next two\n"
      "dead_band_uncertainty_V = {12}\n"
      "gain_uncertainty_percent = {13}\n"
      "measured_check = {14}  # fits the measured numbers as they stand here\n"
      "measured_rig_check = {15}  # fits card, channels and calibration\n",
      in, positive, factor * run.sheet.gain_positive_in_per_V_s.value, negative,
      factor * run.sheet.gain_negative_in_per_V_s.value, null, dead_band, run.sheet.dead_band_V.value,
      config::kDeadBandSpare_V, factor * following.limit_in, following.pressure_delay_s, null_slack, dead_band_slack,
      gain_slack, config::measured_check_of(read), *following.measured_rig_check);
}

std::string experiment_lines(const RunSheet& run) {
  return config::start_at_middle(run.rig) +
         "  # the middle of the travel\n"
         "# offset_V of its [excitation]: `eha check` of its file rehearses it\n"
         "# with these numbers and names the one at which the rod does not drift.\n";
}

bool is_in_rig_file(const RunSheet& run) {
  if (!run.rig.limits.following || !run.rig.limits.following->null_uncertainty_V) return false;
  const config::ValveEstimate there = config::valve_estimate(*run.rig.limits.following);
  const auto is_within = [](const ident::Measured& measured, double value) {
    return std::abs(value - measured.value) <= measured.half_width;
  };
  return is_within(run.sheet.null_V, there.null_V) && is_within(run.sheet.dead_band_V, there.dead_band_V) &&
         is_within(run.sheet.gain_positive_in_per_V_s, there.gain_positive_in_per_V_s) &&
         is_within(run.sheet.gain_negative_in_per_V_s, there.gain_negative_in_per_V_s);
}

bool is_written_since(const RunSheet& run) {
  constexpr double kDecimals = 1e-4;  // of the lines that are written
  std::error_code unknown;
  // The path may be a stranger's, and a pipe without a writer would be waited for.
  if (run.access.rig_file.empty() || !std::filesystem::is_regular_file(run.access.rig_file, unknown)) return false;
  try {
    const auto there = config::load_rig(run.access.rig_file).limits.following;
    if (!there || !there->null_uncertainty_V) return false;
    const config::Following measured = following_of(run);
    const auto is_near = [](double a, double b, double most) { return std::abs(a - b) <= most; };
    constexpr double kShare = 1e-3;  // a gain has four digits
    return is_near(there->null_V, measured.null_V, kDecimals) &&
           is_near(there->dead_band_V, measured.dead_band_V, kDecimals) &&
           is_near(there->gain_positive_in_per_V_s, measured.gain_positive_in_per_V_s,
                   kShare * measured.gain_positive_in_per_V_s) &&
           is_near(there->gain_negative_in_per_V_s, measured.gain_negative_in_per_V_s,
                   kShare * measured.gain_negative_in_per_V_s);
  } catch (const Error&) {  // the file is gone, or no longer a rig's
    return false;
  }
}

std::optional<double> supply_factor(const RunSheet& run) {
  const auto& following = run.rig.limits.following;
  if (!following || !following->gain_uncertainty_percent) return std::nullopt;  // an estimate
  const config::ValveEstimate there = config::valve_estimate(*following);
  return ident::common_gain_factor(run.sheet.gain_positive_in_per_V_s.value / there.gain_positive_in_per_V_s,
                                   run.sheet.gain_negative_in_per_V_s.value / there.gain_negative_in_per_V_s);
}

}  // namespace eha::sheet
