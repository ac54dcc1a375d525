// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a) { return a.eigenvalues(); }

SymmetricEigen symmetric_eigen(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen eigen_of_tridiagonal(const Eigen::VectorXd& diagonal, const Eigen::VectorXd& off) {
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, off);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace eha::ident
