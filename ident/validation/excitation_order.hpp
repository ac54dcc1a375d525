// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>

namespace eha::ident {

/// Returns the order of persistent excitation of an input, as far as its samples show it. Shifts 20 copies of the input
/// evenly over a third of the samples, removes their means, and counts how many are linearly independent to 1 %
/// (singular values above 1 % of the greatest). A tone gives 2, a sum of F tones 2 F, random levels 20. An input that
/// determines n parameters has at least order n.
/// @returns nothing for a constant input or fewer than 120 samples
/// Cost: singular values of a matrix of 400 rows and 20 columns.
/// Soederstroem and Stoica, System Identification (1989), chapter 5.
[[nodiscard]] std::optional<std::size_t> excitation_order(const Eigen::VectorXd& input);

}  // namespace eha::ident
