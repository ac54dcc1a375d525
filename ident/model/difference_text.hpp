// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// "0.02 to 7.9 Hz"; of a single line "0.1 Hz". @param to  between the ends
[[nodiscard]] std::string frequencies_text(const FrequencyInterval& band, std::string_view to = " to ");

/// A difference and the half width beyond which it is one, with so many decimals that the texts tell which is larger.
struct DifferenceText {
  std::string difference;
  std::string half_width;
};
[[nodiscard]] DifferenceText difference_text(double difference, double half_width);

}  // namespace eha::ident
