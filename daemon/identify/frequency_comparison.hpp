// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::identify {

/// Name of the comparison's file, beside data_40ms.csv in a run folder or beside the models of `eha fit -o`.
inline constexpr std::string_view kFrequencyResponseFile = "frequency_response.csv";

/// Periodicity of an excitation.
struct ExcitedPeriod {
  std::size_t samples = 0;               ///< of the shortest period that all lines and the repetitions share; 0: none
  std::vector<double> lines_Hz;          ///< excited ones that are harmonics of it; all of them without a period
  std::vector<double> left_out_Hz = {};  ///< excited ones that are none: the table of a repetition cuts their periods
};

/// @param samples     of the record   @param repetition  samples of one repetition; 0: unknown
/// @throws as ident::excited_lines
[[nodiscard]] ExcitedPeriod excited_period(const ident::Excitation& excitation, double step_s, std::size_t samples,
                                           std::size_t repetition);

/// Measures the frequency response of a source whose experiment is periodic: by its tones, or by its repetitions. The
/// period is the shortest that all lines and the repetitions share. If a repetition cuts the period of a tone, the
/// periods of all tones within the last repetition are taken, after its discarded time, and where it holds no two of
/// them the tones that it cuts are left out. A table of several realisations is measured by them, in its last
/// repetition.
/// @param notes  gets a sentence when the record does not hold two periods after the discarded time, and where tones
///               are left out
/// @returns nothing in that case, and nothing without an experiment
[[nodiscard]] std::optional<ident::FrequencyResponse> frequency_response_of(const Source& source,
                                                                            const ident::FitOptions& options,
                                                                            std::vector<std::string>& notes);

struct GainAndPhase {
  double gain_dB = 0.0;
  double phase_deg = 0.0;
  std::optional<double> gain_std_dB = {};  ///< none for a model without uncertainty
  std::optional<double> phase_std_deg = {};
};

/// One line of the measured response and the models' responses at its frequency.
struct ComparedLine {
  const ident::LineResponse* line = nullptr;  ///< of the measured response, which must outlive this
  GainAndPhase measured;
  double std_percent = 0.0;          ///< of the measured gain [%]
  std::vector<GainAndPhase> models;  ///< in the order of the models
};

/// Compares the measured response with each model's at every line. Phases are unwrapped from line to line, and a
/// model's phase lies within half a turn of the measured one. Cost O(lines models).
[[nodiscard]] std::vector<ComparedLine> compare_lines(const ident::FrequencyResponse& measured,
                                                      const std::vector<IdentifiedModel>& models);

/// Writes the comparison to FOLDER/frequency_response.csv, every line; a missing value is an empty field.
/// @returns the path @throws IoError, PermissionError
std::filesystem::path write_frequency_response(const ident::FrequencyResponse& measured,
                                               const std::vector<IdentifiedModel>& models,
                                               const std::filesystem::path& folder);

}  // namespace eha::identify
