// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <vector>

#include "ident/fractional/transfer_columns.hpp"

namespace eha::ident {

/// The contribution of frequencies above the Nyquist frequency to a sampled transfer function.
///
/// With p = s h = sigma + i theta and F(p) = (G(p/h) - G(inf)) / p, sampling the step response of G at (n - x) h gives
///   exp(-p x) sum_k F(p + 2 pi i k) exp(-2 pi i k x)
/// over all integers k. The terms k != 0 vary slowly with theta; they are evaluated at Chebyshev nodes and given as two
/// real series on the band that is wanted, [-b, b]:
///   S(theta) = sum_even a_n T_n(theta/b) + i sum_odd a_n T_n(theta/b).
/// A narrow band, as a decimation filter leaves it, needs few nodes.
/// |k| = 1..7 are summed one by one, |k| >= 8 by the Abel-Plana formula in its midpoint form, whose main integral is
/// turned to the direction in which exp(-p x) decays (exp-sinh quadrature).
/// Lubich-type contour and aliasing: see Abate and Whitt, Queueing Systems 10 (1992); Abel-Plana: Olver,
/// Asymptotics and Special Functions, ch. 8.
class AliasSum {
 public:
  static constexpr int kExplicitAliases = 7;  ///< aliases summed one by one

  /// Cost: about 0.1 ms.
  /// @param sigma     real part of p, positive
  /// @param step_s    sample period h [s]
  /// @param band      b [rad a sample], at most pi
  /// @param accuracy  relative to the aliases themselves, 3e-13 or more
  AliasSum(double sigma, double step_s, double band, double accuracy);

  /// Coefficients a_n of every column.
  struct Series {
    std::vector<double> a;      ///< as many as there are nodes
    double unresolved_first;    ///< size of the last coefficients of |k| = 1: error from a sharp resonance there
    double unresolved_further;  ///< the same of 2 <= |k| <= 7
  };

  /// @param x  fractional delay in samples, -1/2..1/2
  /// @param skip_first  leaves out |k| <= skip_first (0, 1 or 7); the caller sums these at every bin
  [[nodiscard]] std::vector<Series> evaluate(const TransferColumns& columns, double x, int skip_first) const;

 private:
  struct Node {
    std::size_t offset;  ///< p less the node it serves, as an index
    std::complex<double> weight;
  };
  struct Side {
    LaplacePoints points;
    std::vector<Node> nodes;
    std::vector<std::complex<double>> offsets;
  };
  struct Contour;
  /// Points in the order: first alias, further aliases, tail. One set for each sign of x.
  Side make_side(const Contour& contour, double direction) const;

  Eigen::MatrixXd first_;  ///< values at the nodes -> coefficients, of each group
  Eigen::MatrixXd further_;
  Eigen::MatrixXd tail_;
  Side right_;
  Side left_;
};

}  // namespace eha::ident
