// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace eha::ident {

/// A difference and the half width beyond which it is one, with so many decimals that the texts tell which is larger,
/// and that the difference has two digits of its own.
struct DifferenceText {
  std::string difference;
  std::string half_width;
  double resolution = 0.0;  ///< rounded_to() of it gives the values whose difference this is as many decimals
};
/// @param difference, half_width  in one unit; a half width that is 0 or not finite is shown as it is
[[nodiscard]] DifferenceText difference_text(double difference, double half_width);

}  // namespace eha::ident
