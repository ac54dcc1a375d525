// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ident/estimation/output_error.hpp"
#include "ident/executor.hpp"
#include "ident/record.hpp"
#include "ident/search/least_squares.hpp"

namespace eha::ident {

/// A shorter record of the same experiment for the global search: the input averaged over blocks, the output picked at
/// their starts.
struct CoarseRecord {
  Record record;
  std::size_t first = 0;  ///< first row to compare
  std::size_t rows = 0;   ///< how many
};

/// One coarse record of about a thousand rows, more when the output's spectrum needs them. A long record whose output
/// is fast, or noisy, gives two: one over the whole length, too coarse for the fast part, and one at the spacing the
/// spectrum asks for, from where the input first moves until rows run out.
/// @param first, last  rows of the record that are compared
[[nodiscard]] std::vector<CoarseRecord> coarsen(const Record& record, std::size_t first, std::size_t last);

struct SearchResult {
  std::vector<LeastSquaresResult> optima;  ///< distinct local optima, best first; empty when no trial was stable
  std::size_t evaluations = 0;
};

/// One local search from a start far from the optimum. Before it, the coefficient weights are scanned at the start's
/// orders: coefficients depend on the orders so much that a start's are rarely of use with the orders it names. When an
/// order ran to its end or the search got stuck, the orders are set back to the middle of the search box and the search
/// is repeated once, for a term that has vanished says nothing about its order; the better result counts.
[[nodiscard]] LeastSquaresResult minimise_from_afar(const OutputError& problem, const Eigen::VectorXd& start);

/// Looks over the search box by controlled random searches (NLopt's CRS2 with local mutation, seeded) of four
/// populations at the same time, and polishes the best distinct points it saw, and the best of the guesses, with the
/// local search. Deterministic for a seed, whatever the executor. Kaelo and Ali, J. Optim. Theory Appl. 130 (2006).
/// @param guesses  coordinates worth a start, if any
[[nodiscard]] SearchResult search(const OutputError& problem, const std::vector<Eigen::VectorXd>& guesses,
                                  std::uint64_t seed, const Executor& executor);

}  // namespace eha::ident
