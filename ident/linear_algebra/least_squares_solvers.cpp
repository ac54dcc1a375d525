// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/linear_algebra/least_squares_solvers.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace eha::ident {

void factorise_qr(Eigen::MatrixXd& a) { const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> in_place(a); }

Eigen::VectorXd solve_full_rank(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(a).solve(b);
}

Eigen::MatrixXd solve_pivoted(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::VectorXd solve_ranked(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold,
                             Eigen::MatrixXd* orthonormal) {
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a.rows(), a.cols());
  qr.setThreshold(threshold);
  qr.compute(a);
  if (orthonormal != nullptr) *orthonormal = qr.householderQ() * Eigen::MatrixXd::Identity(a.rows(), qr.rank());
  // qr.solve() would divide by all pivots that are not 0, for any threshold.
  const Eigen::Index rank = qr.rank();
  const Eigen::VectorXd rotated = qr.householderQ().adjoint() * b;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
  x.head(rank) = qr.matrixR().topLeftCorner(rank, rank).triangularView<Eigen::Upper>().solve(rotated.head(rank));
  return qr.colsPermutation() * x;
}

Eigen::MatrixXd semidefinite_root(const Eigen::MatrixXd& a) {
  const Eigen::LDLT<Eigen::MatrixXd> ldlt(a);
  const Eigen::MatrixXd upper = ldlt.matrixU();
  return ldlt.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal() * (upper * ldlt.transpositionsP());
}

Eigen::VectorXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return a.selfadjointView<Eigen::Lower>().ldlt().solve(b);
}

}  // namespace eha::ident
