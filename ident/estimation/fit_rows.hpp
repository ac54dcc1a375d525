// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <utility>

#include "ident/fit_options.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// The rows of a record that are compared with a model. The first `estimating` of them estimate.
struct FitRows {
  std::size_t discarded = 0;
  Comparison comparison;
  std::size_t estimating = 0;
  std::size_t last = 0;  ///< last row of the record that estimates
};

[[nodiscard]] bool is_constant(const Eigen::VectorXd& v);

/// @throws DataError    the record is too short, not finite, or its output is constant
/// @throws ConfigError  decimation or split make no sense
void check_record(const Record& record, const FitOptions& options);

/// @throws DataError  too few rows are left to estimate from
[[nodiscard]] FitRows fit_rows(const Record& record, const FitOptions& options);

/// Least and greatest input of the rows that estimate.
[[nodiscard]] std::pair<double, double> input_range(const Record& record, const FitRows& rows);

/// The inputs of which a model that was estimated within a range tells: half of that range more at either end, or a
/// tenth behind a map. @param range  least and greatest value
[[nodiscard]] std::pair<double, double> covered_inputs(const std::pair<double, double>& range, bool has_map);

/// The level at which the plant is at rest before the record: as given, or of a step test that shows it, unless an
/// initial state is asked for.
[[nodiscard]] std::optional<double> rest_level(const Record& record, const StructureOptions& asked,
                                               const FitOptions& options, const FitRows& rows);

}  // namespace eha::ident
