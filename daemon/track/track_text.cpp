// SPDX-License-Identifier: GPL-3.0-or-later
// What a trial showed, as text and as files.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>

#include "config/bound_text.hpp"
#include "core/os/files.hpp"
#include "daemon/track/track_result.hpp"
#include "ident/valve/supply.hpp"

namespace eha::track {
namespace {

/// What follows from a changed valve where the promise is kept.
constexpr const char* kChangedAndKept =
    "The feedback makes up for it, and the valve is not quite the one that the controller was made for: "
    "`eha characterise` measures it and shows a leak, which is to be repaired first; then `eha tune` gives the "
    "controller the new numbers.";

/// Null without a sweep.
nlohmann::ordered_json sweep_json(const TrackResult& result) {
  if (!result.margins) return nullptr;
  const ident::MeasuredMargins& m = *result.margins;
  nlohmann::ordered_json tones = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < m.w_rad_s.size(); ++i) {
    tones.push_back({{"frequency_Hz", m.w_rad_s[i] / (2.0 * std::numbers::pi)},
                     {"open_loop_real", m.open_loop[i].real()},
                     {"open_loop_imaginary", m.open_loop[i].imag()}});
  }
  const auto value = [](const ident::SweptValue& v) {
    return nlohmann::ordered_json{{"value", v.value}, {"half_width95", v.half_width}};
  };
  return {{"direction", result.margins_retracting ? "retracting" : "extending"},
          {"gain_share", value(m.gain_share)},
          {"lag_s", value(m.lag_s)},
          {"tones", std::move(tones)}};
}

/// "axis: greatest error in the trapezoids 0.00106 in, error at rest 0.001 in; nothing breaks the promise; 11 of 12
/// figures are kept.": what was reached, then whether it was promised.
std::string outcome_text(const TrackResult& result, const DisplayUnit& unit) {
  std::string reached;
  for (const KeptFigure& f : result.figures) {
    const bool is_worst = f.name == "following error, worst";
    if (!is_worst && f.name != "error at rest, worst") continue;
    reached += fmt::format("{} {:.3g} {}, ", is_worst ? "greatest following error" : "at rest",
                           unit.factor(f.unit) * f.measured, unit.of(f.unit));
  }
  return fmt::format("{}: {}{}; {}.", result.controller.name, reached,
                     result.is_kept() ? "nothing breaks the promise" : "the promise is not kept", kept_text(result));
}

}  // namespace

bool goes_to_plc(const TrackResult& result, const DisplayUnit& unit) {
  return !result.leak && advice_of(result, unit).empty();
}

std::string kept_text(const KeptFigure& figure) {
  if (!figure.is_decided()) return "hidden by noise";
  return figure.is_kept() ? "yes" : "no";
}

std::string kept_text(const TrackResult& result) {
  std::size_t broken = 0;
  std::size_t hidden = 0;
  for (const KeptFigure& f : result.figures) (f.is_kept() ? hidden : broken) += f.is_decided() && f.is_kept() ? 0 : 1;
  std::string text =
      fmt::format("{} of {} figures are kept", result.figures.size() - broken - hidden, result.figures.size());
  if (broken > 0) text += fmt::format(", {} {} not", broken, broken == 1 ? "is" : "are");
  if (hidden > 0) text += fmt::format(", {} {} hidden by the sensor's noise", hidden, hidden == 1 ? "is" : "are");
  return text;
}

namespace {

/// How far the generated reference is from a user's set points; empty where it passes through them.
std::string behind_set_points(const TrackResult& result, const DisplayUnit& unit) {
  if (!(result.reference_behind_in > 0.0)) return {};
  return fmt::format(
      "The generated reference is up to {:.3g} {} from the file's set points: it keeps to {:.3g} {} and {:.3g} {}; "
      "where "
      "the rod must reach them, set them farther apart in time.",
      unit.factor("in") * result.reference_behind_in, unit.of("in"),
      unit.factor("in/s") * result.controller.settings.reference.velocity, unit.of("in/s"),
      unit.factor("in/s^2") * result.controller.settings.reference.acceleration, unit.of("in/s^2"));
}

}  // namespace

std::string advice_of(const TrackResult& result, const DisplayUnit& unit) {
  const bool has_changed = !changes_of(result, unit).empty();
  if (result.is_kept() && !has_changed) return behind_set_points(result, unit);
  if (result.leak) return ident::leak_finding(*result.leak, unit);
  const ident::InverseMap& map = result.controller.settings.inverse;
  if (const auto factor = ident::common_gain_factor(result.valve.gain_positive_in_per_V_s / map.gain_positive,
                                                    result.valve.gain_negative_in_per_V_s / map.gain_negative)) {
    return fmt::format("Both gains are {:.2f} times the controller's: {}.", *factor, ident::kSupplyFirst);
  }
  if (result.is_kept()) return kChangedAndKept;
  return fmt::format("Valve, load or sensor differ from what the controller was made for: {}.", ident::kMeasureFirst);
}

std::vector<std::string> sweep_sentences(const TrackResult& result, const DisplayUnit& unit) {
  if (!result.margins) return {"Margins (Ms, Mt, phase, gain, delay) are not measured by this trial."};
  const ident::InverseMap& map = result.controller.settings.inverse;
  const bool is_retracting = result.margins_retracting;
  const double gain = is_retracting ? map.gain_negative : map.gain_positive;
  const ident::SweptValue& share = result.margins->gain_share;
  const double factor = unit.factor(kGainUnit);
  const double ms = result.margins->margins.ms;
  return {fmt::format("By the sweep the gain {} is {:.4g} +- {:.2g} {}, the lag with all delays {:.2g} +- {:.2g} ms "
                      "(95 %).",
                      is_retracting ? "retracting" : "extending", factor * gain * share.value,
                      factor * gain * share.half_width, unit.of(kGainUnit), 1e3 * result.margins->lag_s.value,
                      1e3 * result.margins->lag_s.half_width),
          fmt::format(
              "Margins: of the open loop, from the sweep, in the direction that has less of them; Ms and Mt are the "
              "greatest values at its frequencies. The gain margin is at least Ms / (Ms - 1) = {:.3g}: the sweep ends "
              "below the frequency at which it would be seen, and a loop with this Ms has no less.",
              ms / (ms - 1.0))};
}

std::string track_text(const TrackResult& result, const DisplayUnit& unit) {
  std::string text = outcome_text(result, unit) + "\n";
  for (const std::string& change : changes_of(result, unit)) text += fmt::format("The moving rod shows: {}.\n", change);
  if (const std::string advice = advice_of(result, unit); !advice.empty()) text += advice + "\n";
  text += fmt::format("{:<32} {:>9} {:>14} {:>12}  {:<5} {}\n", "figure", "measured", "noise adds to", "promised",
                      "unit", "kept");
  for (const KeptFigure& f : result.figures) {
    const double factor = unit.factor(f.unit);
    const bool is_most = f.bound == Bound::most;
    text += fmt::format("{:<32} {:>9} {:>14.2g} {:>12}  {:<5} {}\n", f.name,
                        fmt::format("{}{:.3g}", f.is_lower_bound ? ">= " : "", factor * f.measured), factor * f.noise,
                        fmt::format("{} {}", is_most ? "<=" : ">=", config::bound_text(factor * f.limit(), is_most)),
                        unit.of(f.unit), kept_text(f));
  }
  const std::string behind = behind_set_points(result, unit);
  if (!behind.empty() && text.find(behind) == std::string::npos) text += behind + "\n";
  for (const std::string& sentence : sweep_sentences(result, unit)) text += sentence + "\n";
  return text;
}

nlohmann::ordered_json to_json(const TrackResult& result) {
  nlohmann::ordered_json figures = nlohmann::ordered_json::array();
  for (const KeptFigure& f : result.figures) {
    figures.push_back(
        {{"figure", f.name},
         {"unit", f.unit},
         {"measured", f.measured},
         {"noise", f.noise},
         {"promised", f.promised.value},
         {"promised_to", f.limit()},
         {"promised_is", f.bound == Bound::most ? "most" : "least"},
         {"is_lower_bound", f.is_lower_bound},
         {"kept", f.is_decided() ? nlohmann::ordered_json(f.is_kept()) : nlohmann::ordered_json(nullptr)}});
  }
  return {{"schema", "eha-track/1"},
          {"run", result.folder.string()},
          {"controller", result.controller.name},
          {"kept", result.is_kept()},
          {"noise_in", result.noise_in},
          {"reference_behind_in", result.reference_behind_in},
          {"figures", std::move(figures)},
          {"valve",
           {{"null_V", result.valve.null_V},
            {"dead_band_V", result.valve.dead_band_V},
            {"gain_positive_in_per_V_s", result.valve.gain_positive_in_per_V_s},
            {"gain_negative_in_per_V_s", result.valve.gain_negative_in_per_V_s}}},
          {"sweep", sweep_json(result)},
          {"changes", changes_of(result, DisplayUnit("in"))}};
}

void write_track_rows(const TrackResult& result) {
  std::string csv = "time_s,reference_in,displacement_in,error_in,command_V\n";
  const TrackRows& rows = result.rows;
  for (std::size_t i = 0; i < rows.time_s.size(); ++i) {
    csv += fmt::format("{:.6g},{:.7g},{:.7g},{:.4g},{:.6g}\n", rows.time_s[i], rows.reference_in[i], rows.rod_in[i],
                       rows.rod_in[i] - rows.reference_in[i], rows.command_V[i]);
  }
  os::write_file_atomically(result.opened.files() / kTrackRows, csv);
}

void write_track(const TrackResult& result) {
  os::write_file_atomically(result.opened.files() / kTrackFile, to_json(result).dump(2) + "\n");
  write_track_rows(result);
}

}  // namespace eha::track
