// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"

namespace eha::ident {

/// One commensurate model with a given base order.
struct SweepPoint {
  double commensurate_order = 0.0;  ///< q
  std::optional<Model> model;       ///< nothing when no stable model was found
};

/// Fits the structure with its base order q held at each value in turn, to show fit and stability against q.
/// @param structure  with a base order; a request for it is replaced
/// @param orders     values of q, each above 0 and below 2
/// @throws as fit()
/// Cost: one fit a value; they share the executor.
[[nodiscard]] std::vector<SweepPoint> sweep_commensurate_order(const Record& record, const StructureOptions& structure,
                                                               const FitOptions& options,
                                                               const std::vector<double>& orders,
                                                               const Executor& executor = run_in_order);

inline constexpr int kMostSweepOrders = 1000;  ///< each is a fit

/// first, first + step, ... up to last.
/// @throws ConfigError  not 0 < first <= last < 2, step not positive, more than kMostSweepOrders
[[nodiscard]] std::vector<double> order_grid(double first, double last, double step);

/// The sweep as CSV text: q, R2 and fit of both parts, AR-BIC, stability and its margin; empty fields where
/// there is no stable model.
[[nodiscard]] std::string to_csv(const std::vector<SweepPoint>& sweep);

}  // namespace eha::ident
