// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/frequency_comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/realisations.hpp"

namespace eha::identify {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

double decibels(double ratio) { return 20.0 * std::log10(ratio); }

/// Adds the whole turns to `angle_deg` that bring it nearest to `beside_deg`.
double nearest(double angle_deg, double beside_deg) {
  return angle_deg - 360.0 * std::round((angle_deg - beside_deg) / 360.0);
}

std::string field(const std::optional<double>& value) { return value ? fmt::format("{}", *value) : ""; }

/// Returns the samples of the shortest common period of tones and repetitions; 0 for none.
std::size_t period_of(const std::vector<double>& lines_Hz, double step_s, std::size_t samples, std::size_t repetition) {
  const std::size_t shared = ident::common_period(lines_Hz, step_s, samples / 2);
  const bool is_repeated = repetition > 0 && samples > repetition;
  if (!is_repeated || (shared > 0 && repetition % shared == 0)) return shared;
  // A table that does not hold whole periods of its tones jumps at its end, so only the repetitions are periodic.
  return samples >= 2 * repetition ? repetition : 0;
}

/// Returns the realisations of a table, in its last repetition, without those that begin within the discarded rows.
ident::RealisationRows rows_of(const ident::Realisations& table, std::size_t samples, std::size_t table_samples,
                               std::size_t discard) {
  ident::RealisationRows rows{.first = 0,
                              .length = table_samples / (table.count * table.periods),
                              .periods = table.periods,
                              .count = table.count};
  if (samples < table_samples) throw DataError("the record ends before the last realisation");
  rows.first = (samples / table_samples - 1) * table_samples;
  const std::size_t each = rows.length * rows.periods;
  while (rows.count > 0 && rows.first + rows.length < discard) {
    rows.first += each;
    --rows.count;
  }
  return rows;
}

/// The last whole periods of every tone within the last repetition; none where it holds no two behind `discard` rows.
std::optional<ident::Periods> within_repetition(const std::vector<double>& lines_Hz, double step_s, std::size_t samples,
                                                std::size_t repetition, std::size_t discard) {
  if (samples < repetition || discard >= repetition) return std::nullopt;
  const std::size_t end = samples / repetition * repetition;
  const std::size_t length = ident::common_period(lines_Hz, step_s, (repetition - discard) / 2);
  if (length == 0) return std::nullopt;
  return ident::last_periods(end, length, end - repetition + discard);
}

std::string left_out_note(const ExcitedPeriod& excited, const std::vector<double>& lines_Hz, double step_s,
                          std::size_t samples) {
  const double repetition_s = static_cast<double>(excited.samples) * step_s;
  const double shared_s = static_cast<double>(ident::common_period(lines_Hz, step_s, samples)) * step_s;
  const std::string mend = shared_s > 0.0 ? fmt::format("with a duration_s of {:.6g} it would",
                                                        std::ceil(repetition_s / shared_s) * shared_s)
                                          : "choose tones that repeat with it";
  return fmt::format(
      "the measured frequency response lacks {:.4g} Hz: a repetition of {:.6g} s holds no whole number of periods of "
      "{}; {}",
      fmt::join(excited.left_out_Hz, ", "), repetition_s, excited.left_out_Hz.size() == 1 ? "it" : "each", mend);
}

}  // namespace

ExcitedPeriod excited_period(const ident::Excitation& excitation, double step_s, std::size_t samples,
                             std::size_t repetition) {
  ExcitedPeriod excited;
  excited.lines_Hz = ident::excited_lines(excitation, step_s, repetition > 0 ? repetition : samples);
  excited.samples = period_of(excited.lines_Hz, step_s, samples, repetition);
  if (excited.samples == 0) return excited;
  const double period_s = static_cast<double>(excited.samples) * step_s;
  // A tone between two harmonics is not a line. If there is no other tone, the jump at the table's end makes the lines.
  const auto kept = std::stable_partition(excited.lines_Hz.begin(), excited.lines_Hz.end(), [&](double f) {
    return std::abs(f * period_s - std::round(f * period_s)) < 1e-6;
  });
  excited.left_out_Hz.assign(kept, excited.lines_Hz.end());
  excited.lines_Hz.erase(kept, excited.lines_Hz.end());
  return excited;
}

std::optional<ident::FrequencyResponse> frequency_response_of(const Source& source, const ident::FitOptions& options,
                                                              std::vector<std::string>& notes) {
  const config::Played* played = source.experiment ? source.experiment->played() : nullptr;
  if (played == nullptr) return std::nullopt;
  const double step_s = source.record.step_s;
  const auto samples = static_cast<std::size_t>(source.record.input.size());
  try {
    const auto discard = ident::discarded_rows(options.discard_s, step_s);
    if (const auto realisations = ident::realisations_of(played->excitation)) {
      const std::size_t table = source.repetition_samples > 0 ? source.repetition_samples : samples;
      return ident::measure_realisations(source.record, rows_of(*realisations, samples, table, discard),
                                         ident::excited_lines(played->excitation, step_s, table));
    }
    const ExcitedPeriod excited = excited_period(played->excitation, step_s, samples, source.repetition_samples);
    if (excited.samples == 0) {
      if (!excited.lines_Hz.empty()) {
        notes.emplace_back("no frequency response: the record holds no two periods of the excited lines");
      }
      return std::nullopt;
    }
    if (!excited.left_out_Hz.empty()) {
      const std::vector<double> all_Hz = ident::excited_lines(played->excitation, step_s, excited.samples);
      if (const auto periods = within_repetition(all_Hz, step_s, samples, excited.samples, discard)) {
        return ident::measure_frequency_response(source.record, *periods, all_Hz);
      }
      notes.push_back(left_out_note(excited, all_Hz, step_s, samples));
    }
    return ident::measure_frequency_response(source.record, ident::last_periods(samples, excited.samples, discard),
                                             excited.lines_Hz);
  } catch (const Error& error) {
    notes.push_back(fmt::format("no frequency response: {}", error.what()));
    return std::nullopt;
  }
}

std::vector<ComparedLine> compare_lines(const ident::FrequencyResponse& measured,
                                        const std::vector<IdentifiedModel>& models) {
  std::vector<double> frequencies_Hz;
  for (const ident::LineResponse& line : measured.lines) frequencies_Hz.push_back(line.frequency_Hz);
  std::vector<ident::BodeCurve> curves;
  for (const IdentifiedModel& identified : models) {
    curves.push_back(ident::bode_curve(identified.result.model, frequencies_Hz, identified.result.covariance));
  }
  std::vector<ComparedLine> rows;
  for (const ident::LineResponse& line : measured.lines) {
    const std::size_t i = rows.size();
    ComparedLine row{
        .line = &line, .measured = {}, .std_percent = 100.0 * line.std / std::abs(line.response), .models = {}};
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

std::filesystem::path write_frequency_response(const ident::FrequencyResponse& measured,
                                               const std::vector<IdentifiedModel>& models,
                                               const std::filesystem::path& folder) {
  std::string text =
      "frequency_Hz,gain,gain_dB,phase_deg,std,even_distortion_dB,odd_distortion_dB,noise_dB,distortion_dB,odd_"
      "distortion_Hz";
  for (const IdentifiedModel& identified : models) {
    text += fmt::format(",{0}_gain_dB,{0}_gain_std_dB,{0}_phase_deg,{0}_phase_std_deg", identified.result.model.name);
  }
  text += "\n";
  for (const ComparedLine& row : compare_lines(measured, models)) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{}", row.line->frequency_Hz, std::abs(row.line->response),
                        row.measured.gain_dB, row.measured.phase_deg, row.line->std,
                        field(row.line->even_distortion_dB), field(row.line->odd_distortion_dB), row.line->noise_dB,
                        field(row.line->distortion_dB), field(row.line->odd_distortion_Hz));
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

}  // namespace eha::identify
