// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstddef>
#include <vector>

#include "ident/record.hpp"

namespace eha::ident {

/// Poles (stable, conjugates together) and delay of a model guessed from a record.
struct PoleGuess {
  std::vector<std::complex<double>> poles;  ///< [rad/s]
  double delay_s = 0.0;
};

/// Impulse responses estimated from a record at several spacings of its samples, because one spacing does not resolve
/// both fast and slow poles: a long autoregression with exogenous input each. Thread-safe.
/// Zhu, Control Eng. Practice 6 (1998).
class ImpulseResponses {
 public:
  /// @param rows  rows of the record that are used, from the first on; too few give no response. Cost O(rows), about
  ///              10 ms at 1000 rows
  ImpulseResponses(const Record& record, std::size_t rows);

  /// Guesses the poles of a model of integer order without a search, one guess a spacing and delay: the singular
  /// vectors of a response's Hankel matrix give a realisation of the requested order, whose eigenvalues give the poles.
  /// With a free delay the quiet beginning of the impulse response is also cut off. Ho and Kalman, Regelungstechnik 14
  /// (1966); Kung, 12th Asilomar Conf. (1978).
  /// @param poles  1..10
  [[nodiscard]] std::vector<PoleGuess> poles(int poles, bool delay_free) const;

 private:
  struct Response {
    double step_s;
    Eigen::VectorXd h;
    Eigen::MatrixXd observability;  ///< left singular vectors of the Hankel matrix
  };
  std::vector<Response> all_;
};

/// ImpulseResponses::poles() of one record.
[[nodiscard]] std::vector<PoleGuess> guess_poles(const Record& record, std::size_t rows, int poles, bool delay_free);

}  // namespace eha::ident
