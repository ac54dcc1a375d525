// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/kept_values.hpp"

namespace eha::ident {

void each_kept_value(const Eigen::Ref<const Eigen::VectorXd>& values,
                     const std::function<void(Eigen::Index first, Eigen::Index last)>& take) {
  for (Eigen::Index first = 0; first < values.size();) {
    Eigen::Index end = first + 1;
    while (end < values.size() && is_same_value(values[end], values[first])) ++end;
    take(first, end - 1);
    first = end;
  }
}

}  // namespace eha::ident
