// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/eha/identification.hpp"
#include "daemon/eha/source.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::cli {

/// The name of the file that holds it, beside data_40ms.csv in a run folder or beside the models of `eha fit -o`.
inline constexpr std::string_view kFrequencyResponseFile = "frequency_response.csv";

/// The measured frequency response, where the experiment says what is periodic: tones, or repetitions. Its period is
/// the shortest that all lines and the repetitions share. Nothing without an experiment; nothing, and a message that
/// says why, where the record does not hold two periods after the discarded time.
[[nodiscard]] std::optional<ident::FrequencyResponse> frequency_response_of(const Source& source,
                                                                            const ident::FitOptions& options,
                                                                            const Console& console);

/// For people: gain, phase, standard deviation and distortion at each line, each model's gain and phase beside them; of
/// more than 40 lines every so many.
[[nodiscard]] std::string frequency_table(const ident::FrequencyResponse& measured,
                                          const std::vector<IdentifiedModel>& models);

/// The same, every line, numbers in full; what a line cannot tell is null.
[[nodiscard]] nlohmann::ordered_json frequency_json(const ident::FrequencyResponse& measured,
                                                    const std::vector<IdentifiedModel>& models);

/// Writes it to FOLDER/frequency_response.csv, every line; what a line cannot tell is an empty field.
/// @returns the path @throws IoError, PermissionError
std::filesystem::path write_frequency_response(const ident::FrequencyResponse& measured,
                                               const std::vector<IdentifiedModel>& models,
                                               const std::filesystem::path& folder);

}  // namespace eha::cli
