// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <cmath>
#include <random>

#include "ident/linear_algebra/spectra.hpp"

namespace {

using eha::ident::thin_svd;
using eha::ident::ThinSvd;

/// Columns whose sizes fall over ten decades, the last a combination of two others but for 1e-13.
Eigen::MatrixXd graded(Eigen::Index rows, Eigen::Index columns) {
  std::mt19937 draws(7);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd a(rows, columns);
  for (double& value : a.reshaped()) value = normal(draws);
  for (Eigen::Index k = 0; k < columns; ++k)
    a.col(k) *= std::pow(10.0, -10.0 * static_cast<double>(k) / static_cast<double>(columns));
  a.col(columns - 1) = a.col(0) - a.col(1) + 1e-13 * a.col(columns - 1) / a.col(columns - 1).norm();
  return a;
}

class SingularValuesOf : public testing::TestWithParam<Eigen::Index> {};

TEST_P(SingularValuesOf, AreThoseOfTheWholeMatrix) {
  const Eigen::MatrixXd a = graded(GetParam(), 12);
  const ThinSvd found = thin_svd(a);
  const Eigen::VectorXd exact = Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
  ASSERT_EQ(found.left.rows(), a.rows());
  ASSERT_EQ(found.left.cols(), a.cols());
  EXPECT_LT((found.values - exact).cwiseAbs().maxCoeff(), 1e-14 * exact[0]);
  EXPECT_LT((found.left.transpose() * found.left - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-13);
  EXPECT_LT((found.right.transpose() * found.right - Eigen::MatrixXd::Identity(12, 12)).norm(), 1e-13);
  EXPECT_LT((found.left * found.values.asDiagonal() * found.right.transpose() - a).norm(), 1e-14 * a.norm());
}

INSTANTIATE_TEST_SUITE_P(Rows, SingularValuesOf, testing::Values(12, 13, 1250));

TEST(SingularValues, OfNothingAreNothing) {
  EXPECT_EQ(thin_svd(Eigen::MatrixXd::Zero(40, 3)).values, Eigen::VectorXd::Zero(3));
}

}  // namespace
