// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>
#include <vector>

#include "config/valve_estimate.hpp"
#include "core/capitalised.hpp"
#include "core/shell_word.hpp"
#include "daemon/report/html.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "ident/valve/supply.hpp"

namespace eha::sheet {
namespace {

using ident::Measured;

using ident::kWantedNull_V;

std::string with_interval(const Measured& measured, double factor, int digits, const std::string& unit) {
  return fmt::format("{:.{}f} +- {:.{}f}{}{}", factor * measured.value, digits, factor * measured.half_width, digits,
                     unit.empty() ? "" : " ", unit);
}

/// How a quantity is shown: times the factor, with so many digits after the point.
struct Scale {
  double factor = 1.0;
  int digits = 0;
  std::string unit;
};

/// The ratio of two values whose errors are independent.
Measured ratio_of(const Measured& a, const Measured& b) {
  const double ratio = a.value / b.value;
  return {ratio, std::abs(ratio) * std::hypot(a.half_width / a.value, b.half_width / b.value)};
}

std::string crossing(const char* name, const std::optional<Measured>& at_Hz) {
  if (!at_Hz) return fmt::format("{} not observed", name);
  return fmt::format("{} {:.2f} +- {:.2f} Hz", name, at_Hz->value, at_Hz->half_width);
}

/// Adds one or two rows.
void add_response(std::vector<SheetRow>& rows, const ident::AmplitudeResponse& response) {
  if (!response.is_played) {
    rows.push_back(
        {fmt::format("response to {:g} %", response.percent), "not played: limited by slew, range or travel"});
    return;
  }
  const std::string name = fmt::format("response to {:g} % ({:g} V)", response.percent, response.amplitude_V);
  if (response.points.empty()) {
    rows.push_back({name, "not observed: the sines entered the dead band"});
    return;
  }
  rows.push_back({name, fmt::format("measured from {:.2f} to {:.2f} Hz", response.points.front().frequency_Hz,
                                    response.points.back().frequency_Hz)});
  rows.push_back({"", fmt::format("{}, {}", crossing("-3 dB", response.minus_3dB_Hz),
                                  crossing("-90 deg", response.minus_90deg_Hz))});
}

}  // namespace

std::vector<SheetRow> sheet_rows(const RunSheet& run, const DisplayUnit& unit) {
  const ident::ValveSheet& sheet = run.sheet;
  const double factor = unit.factor("in");
  const std::string length = unit.of("in");
  std::vector<SheetRow> rows;
  const auto add = [&](const char* name, const std::string& value) { rows.push_back({name, value}); };
  std::optional<config::ValveEstimate> there;
  if (run.rig.limits.following) there = config::valve_estimate(*run.rig.limits.following);
  // Half the 95 % interval of a number in the rig file, where the file gives one.
  const auto share = [&](double config::ValveEstimate::*gain) {
    const auto& percent = run.rig.limits.following->gain_uncertainty_percent;
    return percent ? std::optional(0.01 * *percent * (*there).*gain) : std::nullopt;
  };
  const auto add_beside = [&](const char* name, const Measured& measured, double config::ValveEstimate::*of_file,
                              const Scale& scale, const std::optional<double>& half_width) {
    SheetRow row{name, with_interval(measured, scale.factor, scale.digits, scale.unit)};
    if (there) {
      const Measured of_rig_file{(*there).*of_file, half_width.value_or(0.0)};
      row.in_rig_file = half_width
                            ? with_interval(of_rig_file, scale.factor, scale.digits, scale.unit)
                            : fmt::format("{:.{}f} {}", scale.factor * of_rig_file.value, scale.digits, scale.unit);
      row.is_as_there =
          std::abs(of_rig_file.value - measured.value) <= std::hypot(measured.half_width, of_rig_file.half_width);
    }
    rows.push_back(std::move(row));
  };
  const Scale volts{1.0, 4, "V"};
  const Scale gain{factor, 5, length + "/(V s)"};
  using Estimate = config::ValveEstimate;
  const config::Following in_file = run.rig.limits.following.value_or(config::Following{});
  add_beside("null", sheet.null_V, &Estimate::null_V, volts, in_file.null_uncertainty_V);
  add_beside("half dead band", sheet.dead_band_V, &Estimate::dead_band_V, volts, in_file.dead_band_uncertainty_V);
  for (const auto& [name, measured, of_file] :
       {std::tuple("velocity gain extending", sheet.gain_positive_in_per_V_s, &Estimate::gain_positive_in_per_V_s),
        std::tuple("velocity gain retracting", sheet.gain_negative_in_per_V_s, &Estimate::gain_negative_in_per_V_s)}) {
    add_beside(name, measured, of_file, gain, there ? share(of_file) : std::nullopt);
  }
  add("retracting / extending",
      with_interval(ratio_of(sheet.gain_negative_in_per_V_s, sheet.gain_positive_in_per_V_s), 1.0, 3, ""));
  add("hysteresis", sheet.has_hysteresis
                        ? with_interval(sheet.hysteresis_V, 1.0, 4, "V")
                        : fmt::format("none found above {:.4f} V", std::max(0.01, sheet.hysteresis_V.half_width)));
  add("drift inside the dead band", sheet.creep_in_per_s
                                        ? with_interval(*sheet.creep_in_per_s, factor, 5, length + "/s")
                                        : "not observed: the dead band is too narrow");
  add("sensor noise, rms", fmt::format("{:.5f} {}", factor * sheet.noise_in, length));
  for (const ident::AmplitudeResponse& response : sheet.responses) add_response(rows, response);
  const std::string unseen = sheet.highest_Hz > 0.0 ? fmt::format("not observed up to {:.2f} Hz", sheet.highest_Hz)
                                                    : std::string("not observed: too few sines were measured");
  add("natural frequency",
      sheet.natural_frequency_Hz ? with_interval(*sheet.natural_frequency_Hz, 1.0, 2, "Hz") : unseen);
  add("damping ratio", sheet.damping_ratio ? with_interval(*sheet.damping_ratio, 1.0, 2, "") : unseen);
  add("delay of the velocity", fmt::format("{:.1f} ms", 1e3 * sheet.lag_s));
  return rows;
}

Origin origin_of(const RunSheet& run) {
  constexpr std::size_t kShownDigits = 12;
  const std::filesystem::path whole = run.folder.lexically_normal();
  const std::filesystem::path name = whole.has_filename() ? whole.filename() : whole.parent_path().filename();
  return {.run = fmt::format("{}, {}", on_one_line(name.string()), report::utc_text(run.utc_start)),
          .rig_file = on_one_line(run.rig_file),
          .sha256 = run.rig_sha256.substr(0, kShownDigits)};
}

std::string sheet_text(const RunSheet& run, const DisplayUnit& unit) {
  std::string text = fmt::format("valve sheet of \"{}\"; +- is half a 95 % interval\n", run.rig.name);
  const Origin origin = origin_of(run);
  const std::string file = std::filesystem::path(origin.rig_file).filename().string();
  text += fmt::format("of {}\nby {}, sha256 {}\n", origin.run, file.empty() ? "a rig file" : file, origin.sha256);
  if (run.rig.limits.following) {
    text += fmt::format("file: what the rig file says, its gains doubled, its dead band less {:g} V\n",
                        config::kDeadBandSpare_V);
  }
  if (run.cut_at_s) text += fmt::format("PARTIAL: of the {:.1f} s until late ticks ended the run\n", *run.cut_at_s);
  for (const SheetRow& row : sheet_rows(run, unit)) {
    text += fmt::format("  {:<26} {}\n", row.name, row.value);
    if (row.in_rig_file.empty()) continue;
    text += fmt::format("  {:<26} (file: {}, {})\n", "", row.in_rig_file, row.is_as_there ? "as before" : "CHANGED");
  }
  return text;
}

std::string next_of(const RunSheet& run, const suggest::RigAccess& rig) {
  if (ident::leak_of(run.sheet)) {
    return fmt::format("{}Next: {}.",
                       run.written ? fmt::format("{} is the rig file with these numbers. ", run.written->file) : "",
                       ident::kRepairFirst);
  }
  if (supply_factor(run)) {
    return fmt::format("{}{}. If the pressure is as it should be, {}.",
                       run.written ? fmt::format("{} is the rig file with these numbers. ", run.written->file) : "",
                       capitalised(ident::kSupplyFirst),
                       run.written ? fmt::format("`eha check {}` leads on", shell_word(run.written->file))
                                   : "they are for the rig file");
  }
  if (run.written) {
    return fmt::format("Next: `{}` checks {}, the rig file with these numbers.", on_one_line(run.written->command),
                       run.written->file);
  }
  // A page may be read from anywhere.
  std::error_code ignored;
  const std::string folder = std::filesystem::absolute(run.folder, ignored).lexically_normal().string();
  const std::string writes = on_one_line(suggest::sheet_into_rig_file(rig, folder));
  if (is_written_since(run)) return fmt::format("{} has these numbers.", run.access.rig_file);
  return is_in_rig_file(run) ? fmt::format(
                                   "The rig file as used had values within these intervals; to write those that were "
                                   "measured here: `{}`.",
                                   writes)
                             : fmt::format("Next: `{}` writes them into a rig file.", writes);
}

std::string warning_of(const RunSheet& run, const DisplayUnit& unit) {
  const std::optional<ident::Leak> leak = ident::leak_of(run.sheet);
  std::string text = leak ? fmt::format("{}; {}", ident::leak_text(*leak, unit), ident::kRepairFirst) : std::string();
  if (const auto factor = supply_factor(run); factor && !leak) {
    text = fmt::format("both gains are {:.2f} times those of [following]: {}", *factor, ident::kSupplyFirst);
  }
  if (!(run.sheet.null_V.half_width > kWantedNull_V)) return text;
  return fmt::format(
      "{}{}the null is known to +-{:.3f} V only, the following check needs {:g} V: with so much leakage or noise the "
      "check may stop a sound rig; repair the seal or the sensor, or widen dead_band_V by as much",
      text, text.empty() ? "" : "; ", run.sheet.null_V.half_width, kWantedNull_V);
}

}  // namespace eha::sheet
