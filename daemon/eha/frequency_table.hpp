// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/identify/identification.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::cli {

/// Writes a table of gain, phase, standard deviation and distortion at each line, with each model's gain and phase.
/// Shows every Nth of more than 40 lines.
[[nodiscard]] std::string frequency_table(const ident::FrequencyResponse& measured,
                                          const std::vector<identify::IdentifiedModel>& models,
                                          const DisplayUnit& unit = {});

/// The same for every line with all digits; a missing value is null.
[[nodiscard]] nlohmann::ordered_json frequency_json(const ident::FrequencyResponse& measured,
                                                    const std::vector<identify::IdentifiedModel>& models);

}  // namespace eha::cli
