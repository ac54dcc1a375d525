// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Frequency of the fastest lightly damped pair of poles (damping below 0.3) of G [Hz]. None for a grey box, for orders
/// that are not whole, or without such a pair.
[[nodiscard]] std::optional<double> fastest_resonance_Hz(const Model& model);

/// The least damping of a pair of poles of G; 1 without a pair, for a grey box and orders that are not whole.
[[nodiscard]] double least_damping(const Model& model);

/// The frequency from which on a resonance may be one above the Nyquist frequency [Hz]: half of that. Input and output
/// on the same rows show a pair of poles at f and one at 1/row_s - f alike where the input is held between the rows.
/// @param row_s  time between the rows [s]
[[nodiscard]] constexpr double ambiguous_from_Hz(double row_s) { return 0.25 / row_s; }

/// "The resonance at 6.06 Hz is more than half the 10 Hz that rows every 0.05 s can show: ..."
[[nodiscard]] std::string fast_resonance_sentence(double resonance_Hz, double row_s);

}  // namespace eha::ident
