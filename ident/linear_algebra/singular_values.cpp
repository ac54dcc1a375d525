// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/QR>
#include <Eigen/SVD>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {

// A tall matrix by its QR factors first, as Chan (1982) proposed: Eigen would reduce the whole of it to two diagonals.
ThinSvd thin_svd(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(a.rows(), a.cols());
  left.topRows(a.cols()) = svd.matrixU();
  left.applyOnTheLeft(qr.householderQ());
  return {left, svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd left_singular_vectors(const Eigen::MatrixXd& a) {
  return Eigen::BDCSVD<Eigen::MatrixXd>(a, Eigen::ComputeThinU).matrixU();
}

}  // namespace eha::ident
