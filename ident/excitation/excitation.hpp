// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/excitation/excitation_options.hpp"

namespace eha::ident {

/// The table of volts that an experiment plays, one a tick, t = k step_s, k = 0..samples-1, offset_V included.
///   multisine, sine       sum_i A_i cos(2 pi f_i t + phase_i)
///   odd_random_multisine  odd harmonics of 1/(samples step_s) in the band, equal amplitudes, random phases; of each
///   four
///                         such lines one at random stays silent, to detect odd distortion; the phases of lowest peak
///                         of 32 draws, then scaled to amplitude_V (Pintelon, Schoukens, System Identification, 4.3)
///   prms                  a level drawn anew every hold_s of `levels` equidistant ones in -amplitude_V..amplitude_V
///   chirp                 amplitude_V sin(2 pi (f_min t + (f_max - f_min) t^2 / (2 T))), T the table's length
///   gaussian              every harmonic of 1/T in the band, Gaussian amplitudes, scaled to the peak amplitude_V
///   step                  0 before hold_s, amplitude_V from then on
/// The same options give the same table on every machine, to the rounding of sin and cos.
/// @param step_s  tick [s], positive   @param samples  at least 1
/// @returns [V]
/// @throws ConfigError  an option that makes no sense for its kind, or a band that holds no line
/// Cost O(samples lines). Thread-safe.
[[nodiscard]] Eigen::VectorXd excitation(const ExcitationOptions& options, double step_s, std::size_t samples);

/// Peak over RMS of a signal, its mean removed: 1.41 for a sine. Throws DataError for an empty or constant signal.
[[nodiscard]] double crest_factor(const Eigen::Ref<const Eigen::VectorXd>& signal);

/// Frequencies that an excitation consists of [Hz], rising; empty for prms, chirp and step, whose spectra are
/// continuous.
/// @throws as excitation()
[[nodiscard]] std::vector<double> excited_lines(const ExcitationOptions& options, double step_s, std::size_t samples);

}  // namespace eha::ident
