// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "daemon/identify/identification.hpp"
#include "ident/estimation/commensurate_sweep.hpp"

namespace eha::identify {

/// Fit and stability against the base order q.
struct CommensurateSweep {
  ident::StructureOptions structure;
  std::vector<ident::SweepPoint> points;
  std::optional<std::size_t> best = {};  ///< index of the point of lowest BIC; none if no point has a model
};

/// Sweeps the task's commensurate structure, or one of two poles and no zero if the task has none.
/// @param orders  values of q, see ident::order_grid
/// @throws as ident::sweep_commensurate_order. Cost: one fit an order.
[[nodiscard]] CommensurateSweep sweep_commensurate_order(const IdentificationTask& task,
                                                         const std::vector<double>& orders, const Progress& progress);

}  // namespace eha::identify
