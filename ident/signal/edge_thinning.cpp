// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/edge_thinning.hpp"

#include <algorithm>
#include <utility>

namespace eha::ident {

EdgeThinning::EdgeThinning(Eigen::VectorXd signal, Thinning thinning)
    : signal_(std::move(signal)), thinning_(std::move(thinning)) {
  const std::size_t outputs = thinning_.weights.size();
  for (Eigen::VectorXd* table : {&of_signal_, &of_constant_, &least_, &greatest_}) {
    table->setZero(static_cast<Eigen::Index>(outputs));
  }
  for (std::size_t k = 0; k < outputs; ++k) {
    const Window w = window(k);
    if (w.count == 0) continue;
    const auto i = static_cast<Eigen::Index>(k);
    of_signal_[i] = filtered(k, [](double u) { return u; });
    of_constant_[i] = filtered(k, [](double) { return 1.0; });
    least_[i] = greatest_[i] = at(w.latest);
    for (std::size_t t = 1; t < w.count; ++t) {
      const double u = at(w.latest - static_cast<std::ptrdiff_t>(t));
      least_[i] = std::min(least_[i], u);
      greatest_[i] = std::max(greatest_[i], u);
    }
  }
}

EdgeThinning::Window EdgeThinning::window(std::size_t output) const {
  const std::ptrdiff_t latest = static_cast<std::ptrdiff_t>(output * thinning_.every) + thinning_.first;
  if (latest < 0) return {latest, 0};
  return {latest, std::min(thinning_.taps.size(), static_cast<std::size_t>(latest) + 1)};
}

double EdgeThinning::at(std::ptrdiff_t sample) const {
  return signal_[std::min<Eigen::Index>(sample, signal_.size() - 1)];
}

template <typename Function>
double EdgeThinning::filtered(std::size_t output, const Function& function) const {
  const Window w = window(output);
  double sum = 0.0;
  if (w.latest < signal_.size()) {
    const double* u = signal_.data() + w.latest;
    for (std::size_t t = 0; t < w.count; ++t, --u) sum += thinning_.taps[t] * function(*u);
  } else {
    for (std::size_t t = 0; t < w.count; ++t) {
      sum += thinning_.taps[t] * function(at(w.latest - static_cast<std::ptrdiff_t>(t)));
    }
  }
  return thinning_.weights[output] * sum;
}

/// @param beyond    output of a window that lies beyond the edge, from those for the signal and for the constant
/// @param function  of one sample
template <typename Beyond, typename Function>
Eigen::VectorXd EdgeThinning::thinned(bool above, double edge, const Beyond& beyond, const Function& function) const {
  Eigen::VectorXd out(of_signal_.size());
  for (Eigen::Index k = 0; k < out.size(); ++k) {
    const bool is_beyond = above ? least_[k] > edge : greatest_[k] < edge;
    const bool is_within = above ? greatest_[k] <= edge : least_[k] >= edge;
    out[k] = is_beyond   ? beyond(of_signal_[k], of_constant_[k])
             : is_within ? 0.0
                         : filtered(static_cast<std::size_t>(k), function);
  }
  return out;
}

Eigen::VectorXd EdgeThinning::excess_above(double edge) const {
  return thinned(
      true, edge, [edge](double signal, double constant) { return signal - edge * constant; },
      [edge](double u) { return std::max(u - edge, 0.0); });
}

Eigen::VectorXd EdgeThinning::excess_below(double edge) const {
  return thinned(
      false, edge, [edge](double signal, double constant) { return signal - edge * constant; },
      [edge](double u) { return std::min(u - edge, 0.0); });
}

Eigen::VectorXd EdgeThinning::is_above(double edge) const {
  return thinned(
      true, edge, [](double, double constant) { return constant; }, [edge](double u) { return u > edge ? 1.0 : 0.0; });
}

Eigen::VectorXd EdgeThinning::is_below(double edge) const {
  return thinned(
      false, edge, [](double, double constant) { return constant; }, [edge](double u) { return u < edge ? 1.0 : 0.0; });
}

}  // namespace eha::ident
