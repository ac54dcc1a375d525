// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/identify/identification.hpp"

namespace eha::cli {

/// The table of models, the notes beneath it, and each model's formula.
/// @param paper  rows for comparison, marked `paper`
[[nodiscard]] std::string model_report(const std::vector<identify::IdentifiedModel>& models,
                                       const std::vector<identify::IdentifiedModel>& paper);

}  // namespace eha::cli
