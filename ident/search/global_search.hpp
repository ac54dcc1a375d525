// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ident/executor.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/record.hpp"
#include "ident/search/least_squares.hpp"

namespace eha::ident {

/// A shorter record of the same experiment for the global search: the input averaged over blocks, the output picked at
/// their starts.
struct CoarseRecord {
  Record record;
  std::size_t first = 0;            ///< first row to compare
  std::size_t rows = 0;             ///< number of rows to compare
  Eigen::VectorXd fine_input = {};  ///< input before it is averaged over blocks
  Eigen::Index block = 1;           ///< its rows a block
};

/// Lowest frequency [cycles a sample] above which the output's increments hold less than a small part of their power.
/// Increments, because the drift of an output has more power than its fast part. Cost O(N log N).
[[nodiscard]] double output_bandwidth(const Eigen::VectorXd& output);

/// One coarse record of about a thousand rows, more when the output's spectrum needs them. A long record with a fast or
/// noisy output gives two: one over the whole length, too coarse for the fast part, and one at the spacing that the
/// spectrum needs, from the first move of the input on, 4000 rows at most.
/// @param bandwidth    of output_bandwidth()
/// @param first, last  rows of the record that are compared
[[nodiscard]] std::vector<CoarseRecord> coarsen(const Record& record, double bandwidth, std::size_t first,
                                                std::size_t last);

/// Distance of the rows, filtered, that a search needs: a thousand rows, more when the output's spectrum needs them.
/// @param bandwidth  of output_bandwidth()
[[nodiscard]] std::size_t search_spacing(double bandwidth, std::size_t last);

/// Whether there are so many coefficient weights that the populations of a search cover its box sparsely. More of the
/// optima found are then worth following.
[[nodiscard]] bool is_thinly_covered(const Parametrisation& parametrisation);

struct SearchResult {
  std::vector<LeastSquaresResult> optima;  ///< distinct local optima, best first; empty when no trial was stable
  Work work;
};

/// One local search from a start far from the optimum. First scans the coefficient weights at the start's orders,
/// because good coefficients depend strongly on the orders. When an order ends near a bound or the search reaches its
/// evaluation limit, sets the orders to the middle of the search box and repeats the search once: a term that has
/// vanished no longer determines its order. Keeps the better result.
[[nodiscard]] LeastSquaresResult minimise_from_afar(const OutputError& problem, const Eigen::VectorXd& start);

enum class Wanted {
  best,      ///< one optimum: a search that by its linearised problem comes to no lower cost than the best drops out
  distinct,  ///< others beside it
};

/// A race of rough local searches from the distinct starts; what meets a better one or costs far more drops out.
/// @returns the distinct optima, best first
[[nodiscard]] SearchResult polished(const OutputError& problem, const std::vector<Eigen::VectorXd>& starts,
                                    Wanted wanted, const Executor& executor);

/// Scans the search box by controlled random searches (NLopt's CRS2 with local mutation, seeded) of four populations at
/// the same time, and polishes the best distinct points it saw, and the best of the guesses, as polished() does.
/// Deterministic for a seed, whatever the executor. Kaelo and Ali, J. Optim. Theory Appl. 130 (2006).
/// @param guesses  coordinates worth a start, if any
[[nodiscard]] SearchResult search(const OutputError& problem, const std::vector<Eigen::VectorXd>& guesses,
                                  std::uint64_t seed, const Executor& executor);

}  // namespace eha::ident
