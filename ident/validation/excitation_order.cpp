// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/excitation_order.hpp"

#include <algorithm>

#include "ident/linear_algebra/spectra.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kCopies = 20;
constexpr Eigen::Index kSpan = 3;  // the copies are shifted over 1/kSpan of the samples
constexpr Eigen::Index kMostRows = 400;
constexpr double kIndependent = 0.01;

}  // namespace

std::optional<std::size_t> excitation_order(const Eigen::VectorXd& input) {
  const Eigen::Index shift = input.size() / kSpan / kCopies;
  if (shift < 2 || !(input.maxCoeff() > input.minCoeff())) return {};
  const Eigen::Index starts = input.size() - (kCopies - 1) * shift;
  const Eigen::Index rows = std::min(starts, kMostRows);
  Eigen::MatrixXd copies(rows, kCopies);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Eigen::Index start = i * (starts - 1) / (rows - 1);
    for (Eigen::Index k = 0; k < kCopies; ++k) copies(i, k) = input[start + k * shift];
  }
  // Centred by columns: this removes an offset even if the input ends within a period.
  copies.rowwise() -= copies.colwise().mean().eval();
  const Eigen::VectorXd values = thin_svd(copies).values;
  return static_cast<std::size_t>((values.array() > kIndependent * values[0]).count());
}

}  // namespace eha::ident
