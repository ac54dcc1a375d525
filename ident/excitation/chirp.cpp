// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/chirp.hpp"

#include <cmath>
#include <numbers>

namespace eha::ident {

Eigen::VectorXd Chirp::volts(double step_s, std::size_t samples) const {
  const auto count = static_cast<Eigen::Index>(samples);
  const double rate = (band.max_Hz - band.min_Hz) / (2.0 * (static_cast<double>(count) * step_s));
  return Eigen::VectorXd::NullaryExpr(count, [&](Eigen::Index k) {
    const double time_s = static_cast<double>(k) * step_s;
    return amplitude_V * std::sin(2.0 * std::numbers::pi * (band.min_Hz + rate * time_s) * time_s);
  });
}

}  // namespace eha::ident
