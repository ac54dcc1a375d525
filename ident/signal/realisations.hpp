// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "ident/record.hpp"
#include "ident/signal/frequency_response.hpp"

namespace eha::ident {

/// Rows of several realisations, one directly after the other.
struct RealisationRows {
  std::size_t first = 0;    ///< row of the first realisation's first period
  std::size_t length = 0;   ///< samples of one period
  std::size_t periods = 0;  ///< of each realisation, at least 3; its first one is a transient and not used
  std::size_t count = 0;    ///< realisations, at least 2
};

/// Measures the best linear approximation of a plant from several realisations of a multisine, and separates the
/// contributions of noise and distortion. With G_m(k) the response of realisation m at line k from the mean of its
/// periods, and n_m^2 the variance of G_m by noise, from the spread of its periods:
///   G = mean_m G_m,   s_total^2 = sum_m |G_m - G|^2 / (M - 1),   s_distortion^2 = s_total^2 - mean_m n_m^2
/// G has the variance s_total^2 / M. Even and odd distortion beside the lines are mean powers over the realisations, as
/// measure_frequency_response() gives each. A distortion is given only if it exceeds twice its standard error under
/// chance alone.
/// @param lines_Hz  excited frequencies, the same in every realisation
/// @throws DataError  as measure_frequency_response(), or too few rows, periods or realisations
/// Cost O(N log N). Thread-safe.
/// Pintelon, Schoukens, System Identification: A Frequency Domain Approach, 2nd ed. (2012), sec. 4.3.1.
[[nodiscard]] FrequencyResponse measure_realisations(const Record& record, const RealisationRows& rows,
                                                     const std::vector<double>& lines_Hz);

}  // namespace eha::ident
