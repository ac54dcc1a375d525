// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace eha::ident {

/// One cosine amplitude_V cos(2 pi frequency_Hz t + phase_rad).
struct Tone {
  double frequency_Hz = 0.0;
  double amplitude_V = 0.0;
  double phase_rad = 0.0;
};

enum class ExcitationKind { multisine, odd_random_multisine, prms, chirp, gaussian, step, sine };

/// What is played on the valve; which members matter depends on `kind`.
struct ExcitationOptions {
  ExcitationKind kind = ExcitationKind::multisine;
  std::vector<Tone> tones;        ///< multisine; sine: exactly one
  double offset_V = 0.0;          ///< added to every sample [V]
  double amplitude_V = 0.0;       ///< peak of the other kinds [V]
  double frequency_min_Hz = 0.0;  ///< band of odd_random_multisine, gaussian and chirp [Hz]
  double frequency_max_Hz = 0.0;
  int levels = 0;          ///< prms: number of amplitudes, at least 3
  double hold_s = 0.0;     ///< prms: shortest time on one level; step: time before the step [s]
  std::uint64_t seed = 1;  ///< random kinds
};

}  // namespace eha::ident
