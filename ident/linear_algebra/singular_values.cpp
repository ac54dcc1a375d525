// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/SVD>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {

ThinSvd thin_svd(const Eigen::MatrixXd& a) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
  return {svd.matrixU(), svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd left_singular_vectors(const Eigen::MatrixXd& a) {
  return Eigen::BDCSVD<Eigen::MatrixXd>(a, Eigen::ComputeThinU).matrixU();
}

}  // namespace eha::ident
