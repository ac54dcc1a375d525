// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ident/fractional/transfer_function.hpp"

namespace eha::ident {

/// One term (coefficient + log_coefficient ln s) s^order.
struct LogTerm {
  double coefficient = 0.0;
  double log_coefficient = 0.0;
  double order = 0.0;
};

/// Derivative of G = exp(-tau s) N/D by one parameter: dN, dD as polynomials with logarithms, and dtau.
struct Sensitivity {
  std::vector<LogTerm> numerator;
  std::vector<LogTerm> denominator;
  double delay = 0.0;
};

/// Points of the Laplace plane by magnitude and angle.
struct LaplacePoints {
  std::vector<double> log_magnitude;  ///< ln |s|
  std::vector<double> angle;          ///< arg s [rad]
  [[nodiscard]] std::size_t size() const noexcept { return angle.size(); }
  void add(double re, double im);
};

/// A family of transfer functions that share one denominator D(s), evaluated together so that each power of s is
/// computed once: numerators[m](s)/D(s), then for every sensitivity of G = N/D
///   (dN - G dD)/D - s dtau G.
/// The caller applies the factor exp(-tau s).
class TransferColumns {
 public:
  /// @param numerators  each a list of terms; @param g  supplies D and the N of the sensitivities
  TransferColumns(const TransferFunction& g, const std::vector<std::vector<Term>>& numerators,
                  const std::vector<Sensitivity>& sensitivities);

  [[nodiscard]] std::size_t columns() const noexcept { return columns_.size(); }

  /// Limit of column c for s to +infinity; 0 unless numerator and denominator have the same highest order.
  [[nodiscard]] double direct(std::size_t c) const noexcept { return columns_[c].direct; }

  /// Columns at points[first, first + count): re[c * stride + i], im[c * stride + i].
  /// Cost: one complex power a distinct order and point, less for integer orders. Thread-safe.
  void evaluate(const LaplacePoints& points, std::size_t first, std::size_t count, double* re, double* im,
                std::size_t stride) const;

 private:
  struct Weighted {
    std::size_t power;
    double coefficient;
    double log_coefficient;
  };
  struct Column {
    std::vector<Weighted> numerator;
    std::vector<Weighted> denominator;  ///< times -G; sensitivities only
    double delay = 0.0;
    double direct = 0.0;
  };
  std::size_t power(double order);
  [[nodiscard]] std::vector<Weighted> weigh(const std::vector<Term>& terms);
  [[nodiscard]] std::vector<Weighted> weigh(const std::vector<LogTerm>& terms);

  std::vector<double> orders_;
  std::vector<std::size_t> factors_;  ///< index of the order one lower, computed before; 0 for none
  std::size_t unit_ = 0;              ///< index of order 1
  std::vector<Weighted> numerator_;
  std::vector<Weighted> denominator_;
  std::vector<Column> columns_;
  bool has_sensitivities_ = false;
};

}  // namespace eha::ident
