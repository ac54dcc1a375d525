// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/prms.hpp"

#include <algorithm>
#include <cmath>

#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {

Eigen::VectorXd Prms::volts(double step_s, std::size_t samples) const {
  PortableDraw draw(seed);
  const auto hold = std::max<Eigen::Index>(1, std::llround(hold_s / step_s));
  const double spacing_V = 2.0 * amplitude_V / (levels - 1);
  Eigen::VectorXd table_V(static_cast<Eigen::Index>(samples));
  double level_V = 0.0;
  for (Eigen::Index k = 0; k < table_V.size(); ++k) {
    if (k % hold == 0) {
      level_V = -amplitude_V + spacing_V * static_cast<double>(draw.below(static_cast<std::uint64_t>(levels)));
    }
    table_V(k) = level_V;
  }
  return table_V;
}

}  // namespace eha::ident
