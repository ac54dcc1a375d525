// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <cstddef>
#include <optional>
#include <vector>

#include "ident/record.hpp"
#include "ident/signal/periods.hpp"

namespace eha::ident {

/// Measured response at one excited frequency.
struct LineResponse {
  double frequency_Hz = 0.0;
  std::size_t harmonic = 0;       ///< of the period
  std::complex<double> response;  ///< G(j 2 pi f) [output unit / input unit]
  /// Standard deviation of the gain, sqrt(E |error|^2 / 2): by noise alone, or with several realisations by noise and
  /// distortion [output unit / input unit].
  double std = 0.0;
  double input_amplitude = 0.0;   ///< of the cosine [input unit]
  double output_amplitude = 0.0;  ///< [output unit]
  /// Output at the neighbouring lines that are not excited, below the output at this line [dB]: the effect of an even
  /// or an odd nonlinearity, noise included. Empty if there is no such line.
  std::optional<double> even_distortion_dB;
  std::optional<double> odd_distortion_dB;
  std::optional<double> odd_distortion_Hz;  ///< frequency of the line that odd_distortion_dB is measured at
  double noise_dB = 0.0;  ///< noise at such a line, below the output: a distortion near this level is noise
  /// Distortion at the line itself, below the output: the difference between realisations that is not noise. Empty for
  /// a single realisation, and if it cannot be distinguished from the noise.
  std::optional<double> distortion_dB = {};
};

/// Powers in the excited band, the mean of a line, relative to the mean output of an excited line [dB]. Noise is
/// subtracted from the distortions; a distortion is empty if it cannot be distinguished from noise. Noise is that of
/// one realisation's mean period.
struct DistortionLevels {
  double noise_dB = 0.0;
  std::optional<double> excited_dB = {};  ///< at the excited lines
  std::optional<double> even_dB = {};     ///< at the even lines
  std::optional<double> odd_dB = {};      ///< at the odd lines that are not excited
};

/// Mean power of a line that is not excited, from two below the lowest excited line to two above the highest
/// [output unit^2], noise included; empty where there is none.
struct SilentPowers {
  std::optional<double> even = {};
  std::optional<double> odd = {};
};

/// The nonparametric frequency response of a record.
struct FrequencyResponse {
  Periods periods;
  std::vector<LineResponse> lines;  ///< rising
  double noise_std = 0.0;           ///< of one output sample [output unit]
  double signal_to_noise_dB = 0.0;  ///< of the output
  double drift_range = 0.0;         ///< removed from the output [output unit]
  bool drift_detected = false;
  SilentPowers silent;  ///< empty unless every excited line is odd
  std::size_t realisations = 1;
  std::optional<DistortionLevels> levels = {};  ///< of several realisations
};

/// Measures the frequency response of a plant at the lines of a periodic input: with a nonlinear plant its best linear
/// approximation for this input.
///   G(j w_k) = mean_p Y_p(k) / (mean_p U_p(k) H(w_k)),  H(w) = (1 - exp(-j w h)) / (j w h)
/// Y_p, U_p are the discrete Fourier transforms of period p, the output's drift removed (average_periods); H is the
/// hold of the input between samples. The plant's response above the sampling frequency folds back onto the line, with
/// a relative error of about (f h)^(1 + r), r the plant's roll-off order.
///   std^2 = sum_p |Y_p - Y - G (U_p - U)|^2 / (2 count (count - 1) |U H|^2), averaged over the two harmonics on either
///           side too, so that a few periods do.
/// Distortion: with odd lines excited, an even nonlinearity responds at even harmonics only, an odd one at odd
/// harmonics only. Both are measured only if every excited harmonic is odd: even distortion at the even harmonics
/// beside the line, odd distortion at the unexcited odd harmonic that is nearest on a logarithmic axis, at most an
/// octave and 14 harmonics away, or the line's third harmonic: the output changes with frequency, and a
/// ratio to a distant line would say nothing. The input's own content at those harmonics is subtracted with the
/// response of the line.
/// @param lines_Hz  excited frequencies, harmonics of the period; empty: the harmonics whose input amplitude is at
///                  least a tenth of the greatest
/// @throws DataError  a line is no harmonic of the period or carries no input; the periods do not fit the record
/// Cost O(N log N). Thread-safe.
/// Pintelon, Schoukens, System Identification: A Frequency Domain Approach, 2nd ed. (2012), sec. 2.5, 4.3.
[[nodiscard]] FrequencyResponse measure_frequency_response(const Record& record, const Periods& periods,
                                                           const std::vector<double>& lines_Hz);

}  // namespace eha::ident
