// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/band_text.hpp"

#include <fmt/format.h>

namespace eha::ident {

std::string frequencies_text(const FrequencyInterval& band, std::string_view to) {
  if (!(band.highest_Hz > band.lowest_Hz)) return fmt::format("{:.3g} Hz", band.lowest_Hz);
  return fmt::format("{:.3g}{}{:.3g} Hz", band.lowest_Hz, to, band.highest_Hz);
}

}  // namespace eha::ident
