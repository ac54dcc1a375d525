// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/frequency_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "daemon/eha/text_table.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::cli {
namespace {

constexpr std::size_t kMostRows = 40;
constexpr double kDegrees = 180.0 / std::numbers::pi;

double decibels(double ratio) { return 20.0 * std::log10(ratio); }

/// The angle that is `angle_deg` but for whole turns, nearest to `beside_deg`.
double nearest(double angle_deg, double beside_deg) {
  return angle_deg - 360.0 * std::round((angle_deg - beside_deg) / 360.0);
}

struct GainAndPhase {
  double gain_dB = 0.0;
  double phase_deg = 0.0;
  std::optional<double> gain_std_dB = {};  ///< none for a model without uncertainty
  std::optional<double> phase_std_deg = {};
};

struct Row {
  const ident::LineResponse* line = nullptr;
  GainAndPhase measured;
  double std_percent = 0.0;
  std::vector<GainAndPhase> models;
};

/// Phases without jumps of a turn from line to line, and from the measured one to the models'.
std::vector<Row> rows_of(const ident::FrequencyResponse& measured, const std::vector<IdentifiedModel>& models) {
  std::vector<double> frequencies_Hz;
  for (const ident::LineResponse& line : measured.lines) frequencies_Hz.push_back(line.frequency_Hz);
  std::vector<ident::BodeCurve> curves;
  for (const IdentifiedModel& identified : models) {
    curves.push_back(ident::bode_curve(identified.result.model, frequencies_Hz, identified.result.covariance));
  }
  std::vector<Row> rows;
  for (const ident::LineResponse& line : measured.lines) {
    const std::size_t i = rows.size();
    Row row{.line = &line, .measured = {}, .std_percent = 100.0 * line.std / std::abs(line.response), .models = {}};
    const double angle_deg = std::arg(line.response) * kDegrees;
    row.measured = {decibels(std::abs(line.response)),
                    rows.empty() ? angle_deg : nearest(angle_deg, rows.back().measured.phase_deg)};
    for (const ident::BodeCurve& curve : curves) {
      GainAndPhase model{curve.gain_dB[i], nearest(curve.phase_deg[i], row.measured.phase_deg)};
      if (!curve.gain_std_dB.empty()) {
        model.gain_std_dB = curve.gain_std_dB[i];
        model.phase_std_deg = curve.phase_std_deg[i];
      }
      row.models.push_back(model);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string cell(const std::optional<double>& level_dB) { return level_dB ? fmt::format("{:.1f}", *level_dB) : "-"; }
std::string std_cell(const std::optional<double>& std) { return std ? fmt::format("{:.2g}", *std) : "-"; }
std::string field(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }

nlohmann::ordered_json number_or_null(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? nlohmann::ordered_json(*value) : nlohmann::ordered_json();
}

/// Samples of the period in which everything the experiment plays comes round again; 0 for none.
std::size_t period_of(const Source& source, const std::vector<double>& lines_Hz) {
  const auto samples = static_cast<std::size_t>(source.record.input.size());
  const std::size_t shared = ident::common_period(lines_Hz, source.record.step_s, samples / 2);
  const std::size_t repetition = source.repetition_samples;
  if (repetition == 0 || samples < 2 * repetition) return shared;
  // A table that does not end where its tones began starts anew with every repetition.
  return shared > 0 && repetition % shared == 0 ? shared : repetition;
}

std::string summary(const ident::FrequencyResponse& measured, const ident::Model* model) {
  const std::string unit = model != nullptr ? model->output_unit : "";
  std::string text =
      fmt::format("frequency response, mean of {} periods; output noise {:.3g} {} (signal to noise {:.1f} dB)",
                  measured.periods.count, measured.noise_std, unit, measured.signal_to_noise_dB);
  if (measured.drift_detected) text += fmt::format("; drift of {:.3g} {} removed", measured.drift_range, unit);
  return text + "\n";
}

}  // namespace

std::optional<ident::FrequencyResponse> frequency_response_of(const Source& source, const ident::FitOptions& options,
                                                              const Console& console) {
  if (!source.experiment) return std::nullopt;
  const double step_s = source.record.step_s;
  const auto samples = static_cast<std::size_t>(source.record.input.size());
  try {
    const std::size_t table = source.repetition_samples > 0 ? source.repetition_samples : samples;
    std::vector<double> lines_Hz = ident::excited_lines(source.experiment->excitation, step_s, table);
    const std::size_t period = period_of(source, lines_Hz);
    if (period == 0) {
      if (!lines_Hz.empty())
        console.info("no frequency response: the record holds no two periods of the excited lines");
      return std::nullopt;
    }
    const double period_s = static_cast<double>(period) * step_s;
    const bool harmonic = std::all_of(lines_Hz.begin(), lines_Hz.end(), [&](double f) {
      return std::abs(f * period_s - std::round(f * period_s)) < 1e-6;
    });
    if (!harmonic) lines_Hz.clear();
    const auto discard = ident::discarded_rows(options.discard_s, step_s);
    return ident::measure_frequency_response(source.record, ident::last_periods(samples, period, discard), lines_Hz);
  } catch (const Error& error) {
    console.info(fmt::format("no frequency response: {}", error.what()));
    return std::nullopt;
  }
}

std::string frequency_table(const ident::FrequencyResponse& measured, const std::vector<IdentifiedModel>& models) {
  std::vector<Column> columns{{"line Hz", Align::right}, {"gain dB", Align::right}, {"phase deg", Align::right},
                              {"std %", Align::right},   {"even dB", Align::right}, {"odd dB", Align::right}};
  for (const IdentifiedModel& identified : models) {
    columns.push_back({identified.result.model.name + " dB", Align::right});
    columns.push_back({"+-", Align::right});
    columns.push_back({"deg", Align::right});
    columns.push_back({"+-", Align::right});
  }
  const std::vector<Row> rows = rows_of(measured, models);
  const std::size_t every = (rows.size() + kMostRows - 1) / kMostRows;
  std::vector<std::vector<std::string>> cells;
  for (std::size_t i = 0; i < rows.size(); i += every) {
    const Row& row = rows[i];
    cells.push_back({fmt::format("{:.5g}", row.line->frequency_Hz), fmt::format("{:.2f}", row.measured.gain_dB),
                     fmt::format("{:.1f}", row.measured.phase_deg), fmt::format("{:.2g}", row.std_percent),
                     cell(row.line->even_distortion_dB), cell(row.line->odd_distortion_dB)});
    for (const GainAndPhase& model : row.models) {
      cells.back().push_back(fmt::format("{:.2f}", model.gain_dB));
      cells.back().push_back(std_cell(model.gain_std_dB));
      cells.back().push_back(fmt::format("{:.1f}", model.phase_deg));
      cells.back().push_back(std_cell(model.phase_std_deg));
    }
  }
  std::string text = summary(measured, models.empty() ? nullptr : &models.front().result.model);
  text += text_table(columns, cells);
  text +=
      "std: of the gain, by noise alone; even, odd: distortion beside the line, below its output; +-: standard error\n";
  if (every > 1)
    text +=
        fmt::format("one line in {} of {}; {} and --json have them all\n", every, rows.size(), kFrequencyResponseFile);
  return text;
}

nlohmann::ordered_json frequency_json(const ident::FrequencyResponse& measured,
                                      const std::vector<IdentifiedModel>& models) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const Row& row : rows_of(measured, models)) {
    nlohmann::ordered_json entry{{"frequency_Hz", row.line->frequency_Hz},
                                 {"gain", std::abs(row.line->response)},
                                 {"gain_dB", number_or_null(row.measured.gain_dB)},
                                 {"phase_deg", row.measured.phase_deg},
                                 {"std", row.line->std},
                                 {"input_amplitude", row.line->input_amplitude},
                                 {"output_amplitude", row.line->output_amplitude},
                                 {"even_distortion_dB", number_or_null(row.line->even_distortion_dB)},
                                 {"odd_distortion_dB", number_or_null(row.line->odd_distortion_dB)}};
    for (std::size_t m = 0; m < models.size(); ++m) {
      entry["models"][models[m].result.model.name] = {{"gain_dB", number_or_null(row.models[m].gain_dB)},
                                                      {"gain_std_dB", number_or_null(row.models[m].gain_std_dB)},
                                                      {"phase_deg", row.models[m].phase_deg},
                                                      {"phase_std_deg", number_or_null(row.models[m].phase_std_deg)}};
    }
    lines.push_back(std::move(entry));
  }
  return {{"periods", measured.periods.count},
          {"period_samples", measured.periods.length},
          {"first_sample", measured.periods.first},
          {"noise_std", measured.noise_std},
          {"signal_to_noise_dB", number_or_null(measured.signal_to_noise_dB)},
          {"drift_range", measured.drift_range},
          {"drift_detected", measured.drift_detected},
          {"lines", std::move(lines)}};
}

std::filesystem::path write_frequency_response(const ident::FrequencyResponse& measured,
                                               const std::vector<IdentifiedModel>& models,
                                               const std::filesystem::path& folder) {
  std::string text = "frequency_Hz,gain,gain_dB,phase_deg,std,even_distortion_dB,odd_distortion_dB";
  for (const IdentifiedModel& identified : models) {
    text += fmt::format(",{0}_gain_dB,{0}_gain_std_dB,{0}_phase_deg,{0}_phase_std_deg", identified.result.model.name);
  }
  text += "\n";
  for (const Row& row : rows_of(measured, models)) {
    text += fmt::format("{},{},{},{},{},{},{}", row.line->frequency_Hz, std::abs(row.line->response),
                        row.measured.gain_dB, row.measured.phase_deg, row.line->std,
                        field(row.line->even_distortion_dB), field(row.line->odd_distortion_dB));
    for (const GainAndPhase& model : row.models) {
      text += fmt::format(",{},{},{},{}", model.gain_dB, field(model.gain_std_dB), model.phase_deg,
                          field(model.phase_std_deg));
    }
    text += "\n";
  }
  std::filesystem::path path = folder / kFrequencyResponseFile;
  os::write_file_atomically(path, text);
  return path;
}

}  // namespace eha::cli
