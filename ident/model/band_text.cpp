// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/band_text.hpp"

#include <fmt/format.h>

namespace eha::ident {

std::string frequencies_text(const FrequencyInterval& band, std::string_view to) {
  if (!(band.highest_Hz > band.lowest_Hz)) return fmt::format("{:.3g} Hz", band.lowest_Hz);
  return fmt::format("{:.3g}{}{:.3g} Hz", band.lowest_Hz, to, band.highest_Hz);
}

std::string no_band_text(const Verdict& verdict) {
  // A single step excites no band, and yet determines gain and time constants.
  return verdict.judging_part_rests
             ? "the input moves too seldom to excite a band of frequencies: gain at rest and time constants hold by "
               "their intervals, faster motions are not tried; play an input that moves more often"
             : "the record determines the response at none of the excited frequencies; record longer, or with more "
               "tones";
}

}  // namespace eha::ident
