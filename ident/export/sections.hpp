// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <vector>

namespace eha::ident {

/// One strictly proper part of a transfer function of integer order n, with sigma = s / rate_rad_s:
///   (b_1 sigma^(n-1) + ... + b_n) / (sigma^n + d_1 sigma^(n-1) + ... + d_n),
/// realised in observer form: x' = rate (A x + b v), y = x_1, A = [-d | shifted identity]. Its poles lie close together
/// (or are a conjugate pair), so with `rate` of their size every number is of order one.
struct Section {
  double rate_rad_s = 1.0;
  std::vector<double> denominator;  ///< d_1 .. d_n
  std::vector<double> numerator;    ///< b_1 .. b_n
  std::vector<double> state;        ///< x at t = 0, n values [output unit]
};

/// y = sum of sections + direct v, v delayed by delay_s; the states at t = 0 are not delayed.
struct Sections {
  std::vector<Section> list;
  double direct = 0.0;
  double delay_s = 0.0;
};

/// One section over one sample period h with the input held: x(h) = a x + b_before v_before + b v, where the input
/// changes from v_before to v at `late_s` into the period.
struct DiscreteSection {
  Eigen::MatrixXd a;
  Eigen::VectorXd b_before;
  Eigen::VectorXd b;
};

/// @param step_s  positive  @param late_s  0 .. step_s
/// The matrix exponential by scaling, Taylor series and squaring; its error is some rounding errors of each pole.
[[nodiscard]] DiscreteSection discretise(const Section& section, double step_s, double late_s = 0.0);

/// Response to N samples of a held input, zero before the first; row k is the output just before v[k] takes effect.
/// Exact up to rounding. Cost O(N states).
[[nodiscard]] Eigen::VectorXd respond(const Sections& sections, const Eigen::Ref<const Eigen::VectorXd>& input,
                                      double step_s);

/// Returns the sum without its delay at s; s is not a pole.
[[nodiscard]] std::complex<double> frequency_response(const Sections& sections, std::complex<double> s);

/// x' = A x + B v(t - delay), y = C x + D v(t - delay), x(0) = x0: the sections as blocks on the diagonal of A.
struct StateSpace {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
  Eigen::VectorXd c;
  double d = 0.0;
  Eigen::VectorXd x0;
};
[[nodiscard]] StateSpace state_space(const Sections& sections);

}  // namespace eha::ident
