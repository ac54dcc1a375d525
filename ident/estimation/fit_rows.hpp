// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

#include "ident/estimation/fit_options.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

/// Which rows of a record are compared, and how many of them estimate.
struct FitRows {
  std::size_t discarded = 0;
  Comparison comparison;
  std::size_t estimating = 0;
  std::size_t last = 0;  ///< last row of the record that estimates
};

/// @throws DataError  too few rows are left to estimate from
[[nodiscard]] FitRows fit_rows(const Record& record, const FitOptions& options);

/// The level at which the plant is at rest before the record: as given, or of a step test that shows it, unless an
/// initial state is asked for.
[[nodiscard]] std::optional<double> rest_level(const Record& record, const StructureOptions& asked,
                                               const FitOptions& options, const FitRows& rows);

}  // namespace eha::ident
