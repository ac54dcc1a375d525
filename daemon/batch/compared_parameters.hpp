// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "daemon/batch/batch_table.hpp"

namespace eha::batch {

/// What a row keeps of a model's figures at rest, which are compared in the place of its parameters.
inline constexpr const char* kAtRest = "figures_at_rest";

/// The model of a name in what a row keeps of its fit; null without one.
[[nodiscard]] const nlohmann::ordered_json* model_of(const nlohmann::ordered_json& fit, const std::string& name);

/// Whether a model of a fit is accepted; one without a verdict is.
[[nodiscard]] bool is_accepted(const nlohmann::ordered_json& model);

/// Reports the records that deviate. @returns the smallest changes that could have been reported
/// Cost O(rows) a parameter.
[[nodiscard]] std::vector<Resolution> mark_outliers(std::vector<Row>& rows, const std::string& model);

/// Parameters that rise or fall over the records in their order, of ten records and more. Cost O(rows^2) a parameter.
[[nodiscard]] std::vector<Trend> trends_of(const std::vector<Parameter>& parameters);

}  // namespace eha::batch
