// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/frequency_table.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "daemon/eha/terminal_table.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::cli {
namespace {

constexpr std::size_t kMostRows = 40;

std::string cell(const std::optional<double>& level_dB) { return level_dB ? fmt::format("{:.1f}", *level_dB) : "-"; }
std::string half_width_cell(const std::optional<double>& std) {
  return std ? fmt::format("{:.2g}", ident::kInterval95 * *std) : "-";
}

nlohmann::ordered_json number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

/// A map before G has no gain of its own at a line: the measured gain lies below those of G on the two sides.
std::string bounds_of_the_linear_part(const ident::Model& model) {
  if (!model.input_map) return "";
  const double ratio = std::abs(model.input_map->negative_gain_ratio);
  return fmt::format(
      "{}: of the linear part above the dead band; below it {:+.2f} dB. The map makes the measured gain "
      "smaller and distorts\n",
      model.name, 20.0 * std::log10(ratio));
}

std::string level_text(const std::optional<double>& level_dB) {
  return level_dB ? fmt::format("{:.1f} dB", *level_dB) : "none beyond the noise";
}

std::string levels_line(const ident::FrequencyResponse& measured) {
  const ident::DistortionLevels& levels = *measured.levels;
  return fmt::format(
      "{} realisations; below the output: noise {:.1f} dB; distortion at the lines {}, even {}, odd {}\n",
      measured.realisations, levels.noise_dB, level_text(levels.excited_dB), level_text(levels.even_dB),
      level_text(levels.odd_dB));
}

std::string summary(const ident::FrequencyResponse& measured, const std::string& unit, double factor) {
  std::string text =
      fmt::format("frequency response, mean of {} periods; output noise {:.3g} {} (signal to noise {:.1f} dB)",
                  measured.periods.count, factor * measured.noise_std, unit, measured.signal_to_noise_dB);
  if (measured.drift_detected) text += fmt::format("; drift of {:.3g} {} removed", factor * measured.drift_range, unit);
  text += "\n";
  if (measured.levels) text += levels_line(measured);
  return text;
}

}  // namespace

std::string frequency_table(const ident::FrequencyResponse& measured,
                            const std::vector<identify::IdentifiedModel>& models, const DisplayUnit& unit) {
  const std::string output_unit = models.empty() ? "" : models.front().result.model.output_unit;
  const double factor = unit.factor(output_unit);
  const double shift_dB = 20.0 * std::log10(factor);
  std::vector<Column> columns{{"line Hz", Align::right}, {"gain dB", Align::right}, {"phase deg", Align::right},
                              {"std %", Align::right},   {"even dB", Align::right}, {"odd dB", Align::right},
                              {"noise dB", Align::right}};
  if (measured.levels) columns.push_back({"dist. dB", Align::right});
  for (const identify::IdentifiedModel& identified : models) {
    columns.push_back({identified.result.model.name + " dB", Align::right});
    columns.push_back({"+-", Align::right});
    columns.push_back({"deg", Align::right});
    columns.push_back({"+-", Align::right});
  }
  const std::vector<identify::ComparedLine> rows = identify::compare_lines(measured, models);
  const std::size_t every = (rows.size() + kMostRows - 1) / kMostRows;
  std::vector<std::vector<std::string>> cells;
  for (std::size_t i = 0; i < rows.size(); i += every) {
    const identify::ComparedLine& row = rows[i];
    cells.push_back({fmt::format("{:.5g}", row.line->frequency_Hz),
                     fmt::format("{:.2f}", row.measured.gain_dB + shift_dB),
                     fmt::format("{:.1f}", row.measured.phase_deg), fmt::format("{:.2g}", row.std_percent),
                     cell(row.line->even_distortion_dB), cell(row.line->odd_distortion_dB),
                     fmt::format("{:.1f}", row.line->noise_dB)});
    if (measured.levels) cells.back().push_back(cell(row.line->distortion_dB));
    for (const identify::GainAndPhase& model : row.models) {
      cells.back().push_back(fmt::format("{:.2f}", model.gain_dB + shift_dB));
      cells.back().push_back(half_width_cell(model.gain_std_dB));
      cells.back().push_back(fmt::format("{:.1f}", model.phase_deg));
      cells.back().push_back(half_width_cell(model.phase_std_deg));
    }
  }
  std::string text = summary(measured, unit.of(output_unit), factor);
  text += text_table(columns, cells);
  text += fmt::format(
      "std: of the gain, by noise {}; even, odd: distortion beside the line, below its output; noise: the same of "
      "noise alone; {}+-: half a 95 % interval\n",
      measured.levels ? "and distortion" : "alone", measured.levels ? "dist.: distortion at the line; " : "");
  for (const identify::IdentifiedModel& identified : models) text += bounds_of_the_linear_part(identified.result.model);
  if (every > 1)
    text += fmt::format("one line in {} of {}; {} and --json have them all\n", every, rows.size(),
                        identify::kFrequencyResponseFile);
  return text;
}

nlohmann::ordered_json frequency_json(const ident::FrequencyResponse& measured,
                                      const std::vector<identify::IdentifiedModel>& models) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const identify::ComparedLine& row : identify::compare_lines(measured, models)) {
    nlohmann::ordered_json entry{{"frequency_Hz", row.line->frequency_Hz},
                                 {"gain", std::abs(row.line->response)},
                                 {"gain_dB", number_or_null(row.measured.gain_dB)},
                                 {"phase_deg", row.measured.phase_deg},
                                 {"std", row.line->std},
                                 {"input_amplitude", row.line->input_amplitude},
                                 {"output_amplitude", row.line->output_amplitude},
                                 {"even_distortion_dB", number_or_null(row.line->even_distortion_dB)},
                                 {"odd_distortion_dB", number_or_null(row.line->odd_distortion_dB)},
                                 {"noise_dB", number_or_null(row.line->noise_dB)},
                                 {"distortion_dB", number_or_null(row.line->distortion_dB)}};
    for (std::size_t m = 0; m < models.size(); ++m) {
      entry["models"][models[m].result.model.name] = {{"gain_dB", number_or_null(row.models[m].gain_dB)},
                                                      {"gain_std_dB", number_or_null(row.models[m].gain_std_dB)},
                                                      {"phase_deg", row.models[m].phase_deg},
                                                      {"phase_std_deg", number_or_null(row.models[m].phase_std_deg)}};
    }
    lines.push_back(std::move(entry));
  }
  nlohmann::ordered_json document{{"periods", measured.periods.count},
                                  {"period_samples", measured.periods.length},
                                  {"first_sample", measured.periods.first},
                                  {"noise_std", measured.noise_std},
                                  {"signal_to_noise_dB", number_or_null(measured.signal_to_noise_dB)},
                                  {"drift_range", measured.drift_range},
                                  {"drift_detected", measured.drift_detected},
                                  {"realisations", measured.realisations}};
  if (measured.levels) {
    document["levels"] = {{"noise_dB", number_or_null(measured.levels->noise_dB)},
                          {"distortion_dB", number_or_null(measured.levels->excited_dB)},
                          {"even_distortion_dB", number_or_null(measured.levels->even_dB)},
                          {"odd_distortion_dB", number_or_null(measured.levels->odd_dB)}};
  }
  document["lines"] = std::move(lines);
  return document;
}

}  // namespace eha::cli
