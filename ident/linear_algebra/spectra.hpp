// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace eha::ident {

// Eigen's eigenvalue and singular value decompositions, each compiled in one source: see least_squares_solvers.hpp.

/// a = left diag(values) right', values falling; as many columns as a has.
struct ThinSvd {
  Eigen::MatrixXd left;
  Eigen::VectorXd values;
  Eigen::MatrixXd right;
};

/// @param a  at least as many rows as columns. Cost O(rows columns^2).
[[nodiscard]] ThinSvd thin_svd(const Eigen::MatrixXd& a);

/// Eigenvalues of a square matrix. Cost O(n^3).
[[nodiscard]] Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a);

/// Eigenvalues, rising, and eigenvectors of a symmetric matrix.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
/// @param a  symmetric; the lower triangle is used. Cost O(n^3).
[[nodiscard]] SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a);
/// @param diagonal  n values; @param off  the n - 1 off-diagonal values
[[nodiscard]] SymmetricEigen eigen_of_tridiagonal(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& off);

}  // namespace eha::ident
