// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <string>
#include <vector>

#include "ident/excitation/tone.hpp"

namespace eha::identify {

/// The table [excitation] of an experiment file for a multisine, without a newline at its end; tones with frequencies
/// [Hz], amplitudes [V] and phases [rad]. @param offset_V  about which they play
[[nodiscard]] inline std::string multisine_table(double offset_V, const std::vector<ident::Tone>& tones) {
  std::string text = fmt::format("[excitation]\nkind = \"multisine\"\noffset_V = {:#}\ntones = [\n", offset_V);
  for (const ident::Tone& tone : tones) {
    text += fmt::format("  {{ frequency_Hz = {:#}, amplitude_V = {:#}, phase_rad = {:#} }},\n", tone.frequency_Hz,
                        tone.amplitude_V, tone.phase_rad);
  }
  return text + "]";
}

}  // namespace eha::identify
