// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::cli {

/// Gain, phase, standard deviation and distortion at each line, each model's gain and phase beside them. Of more than
/// 40 lines it shows every so many.
[[nodiscard]] std::string frequency_table(const ident::FrequencyResponse& measured,
                                          const std::vector<identify::IdentifiedModel>& models);

/// The same, every line, numbers in full; a missing value is null.
[[nodiscard]] nlohmann::ordered_json frequency_json(const ident::FrequencyResponse& measured,
                                                    const std::vector<identify::IdentifiedModel>& models);

}  // namespace eha::cli
