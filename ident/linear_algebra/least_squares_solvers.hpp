// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

// Eigen's decompositions as plain functions. Compiling one costs seconds of processor time, so each is compiled in one
// source only. All are thread-safe and never throw on finite numbers.

/// Overwrites `a` with its Householder QR factorisation: R in the upper triangle. Cost O(rows columns^2).
void factorise_qr(Eigen::MatrixXd& a);

/// min |a x - b| by Householder QR; a has full column rank and at least as many rows as columns.
[[nodiscard]] Eigen::VectorXd solve_full_rank(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

/// min |a x - b| for each column of b, by QR with column pivoting; sets rank-deficient directions to 0.
[[nodiscard]] Eigen::MatrixXd solve_pivoted(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The same for one right side, with the rank decided by `threshold`.
/// @param threshold    a pivot below this share of the largest one does not count
/// @param orthonormal  receives an orthonormal basis of the columns that count; null: not wanted
[[nodiscard]] Eigen::VectorXd solve_ranked(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold,
                                           Eigen::MatrixXd* orthonormal = nullptr);

/// Returns R with R'R = a, which is symmetric and positive semidefinite up to rounding.
[[nodiscard]] Eigen::MatrixXd semidefinite_root(const Eigen::MatrixXd& a);

/// Solves the symmetric positive semidefinite system a x = b by LDL'; the lower triangle of a is used.
[[nodiscard]] Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b);

}  // namespace eha::ident
