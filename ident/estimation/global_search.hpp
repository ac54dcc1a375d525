// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ident/estimation/least_squares.hpp"
#include "ident/estimation/output_error.hpp"
#include "ident/executor.hpp"
#include "ident/record.hpp"

namespace eha::ident {

/// A shorter record of the same experiment for the global search: the input averaged over blocks, the output picked at
/// their starts, about a thousand rows unless the output's spectrum needs more.
struct CoarseRecord {
  Record record;
  std::size_t factor = 1;  ///< rows of the original per row
};

[[nodiscard]] CoarseRecord coarsen(const Record& record);

struct SearchResult {
  std::vector<LeastSquaresResult> optima;  ///< distinct local optima, best first; empty when no trial was stable
  std::size_t evaluations = 0;
};

/// One local search from a start far from the optimum. Before it, the coefficient weights are scanned at the start's
/// orders: coefficients depend on the orders so much that a start's are rarely of use with the orders it names. When an
/// order ran to its end or the search got stuck, the orders are set back to the middle of the search box and the search
/// is repeated once, for a term that has vanished says nothing about its order; the better result counts.
[[nodiscard]] LeastSquaresResult minimise_from_afar(const OutputError& problem, const Eigen::VectorXd& start);

/// Looks over the search box by controlled random search (NLopt's CRS2 with local mutation, seeded) and polishes the
/// best distinct points it saw with the local search. Deterministic for a seed, whatever the executor. Kaelo and Ali,
/// J. Optim. Theory Appl. 130 (2006).
[[nodiscard]] SearchResult search(const OutputError& problem, std::uint64_t seed, const Executor& executor);

}  // namespace eha::ident
