// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/step.hpp"

namespace eha::ident {

Eigen::VectorXd Step::volts(double step_s, std::size_t samples) const {
  // The tick nearest to hold_s, independently of the rounding of k step_s.
  return Eigen::VectorXd::NullaryExpr(static_cast<Eigen::Index>(samples), [&](Eigen::Index k) {
    return static_cast<double>(k) * step_s < hold_s - 0.5 * step_s ? 0.0 : amplitude_V;
  });
}

}  // namespace eha::ident
