// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace eha::ident {

/// Decimating filter: out[k] = weight[k] sum_t taps[t] in[every k + first - t].
struct Thinning {
  std::vector<double> taps;
  std::size_t every = 1;
  std::ptrdiff_t first = 0;     ///< negative: the signal begins that many samples late
  std::vector<double> weights;  ///< one an output
};

/// Thins one signal behind functions that are linear on either side of an edge, as the halves of a valve's map are, for
/// one edge after the other. The signal is 0 before its first sample and keeps its last value. Outputs whose window
/// lies on one side of the edge follow from the thinned signal and the thinned constant, computed once; only windows
/// that cross the edge are filtered anew. Immutable, thread-safe.
/// Cost O(outputs) and O(taps) a crossing; at construction O(outputs taps).
class EdgeThinning {
 public:
  EdgeThinning(Eigen::VectorXd signal, Thinning thinning);

  [[nodiscard]] Eigen::VectorXd excess_above(double edge) const;  ///< of max(u - edge, 0)
  [[nodiscard]] Eigen::VectorXd excess_below(double edge) const;  ///< of min(u - edge, 0)
  [[nodiscard]] Eigen::VectorXd is_above(double edge) const;      ///< of 1 where u > edge, else 0
  [[nodiscard]] Eigen::VectorXd is_below(double edge) const;      ///< of 1 where u < edge, else 0

 private:
  /// Samples of the signal that out[k] depends on, the latest first.
  struct Window {
    std::ptrdiff_t latest;  ///< sample of taps[0]; may lie behind the last one
    std::size_t count;      ///< taps that fall on the signal
  };
  [[nodiscard]] Window window(std::size_t output) const;
  [[nodiscard]] double at(std::ptrdiff_t sample) const;
  template <typename Function>
  [[nodiscard]] double filtered(std::size_t output, const Function& function) const;
  template <typename Beyond, typename Function>
  [[nodiscard]] Eigen::VectorXd thinned(bool above, double edge, const Beyond& beyond, const Function& function) const;

  Eigen::VectorXd signal_;
  Thinning thinning_;
  Eigen::VectorXd of_signal_;    ///< outputs for the signal itself
  Eigen::VectorXd of_constant_;  ///< outputs for 1 from the first sample on
  Eigen::VectorXd least_;        ///< of the signal in the window of each output
  Eigen::VectorXd greatest_;
};

}  // namespace eha::ident
