// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/QR>
#include <Eigen/SVD>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {

// A tall matrix by its QR factors first, as Chan (1982) proposed; the triangle by Jacobi's rotations, which of a few
// dozen columns take as long as a bidiagonalisation and compile in a quarter of the time.
ThinSvd thin_svd(const Eigen::MatrixXd& a) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  const Eigen::MatrixXd r = qr.matrixQR().topRows(a.cols()).triangularView<Eigen::Upper>();
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(r, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(a.rows(), a.cols());
  left.topRows(a.cols()) = svd.matrixU();
  left.applyOnTheLeft(qr.householderQ());
  return {left, svd.singularValues(), svd.matrixV()};
}

}  // namespace eha::ident
