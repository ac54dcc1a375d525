// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <complex>
#include <vector>

#include "daemon/identify/fit_table.hpp"
#include "ident/signal/valve_map.hpp"

namespace eha::report {

/// The linearised response of a valve's map to the input of a fit at lines f_k, which a measured response contains:
///   u(t) = u_0 + sum_k Re U_k exp(i 2 pi f_k t) + rest, map(u(t)) likewise with V_k, both by least squares; V_k / U_k
/// @param input  rows of a fit   @param lines_Hz  not 0, distinct
/// @returns empty if the rows are fewer than two for each coefficient, or the input has no part at a line
/// Gelb and Vander Velde, Multiple-Input Describing Functions (1968), for several tones. Cost O(rows lines^2).
[[nodiscard]] std::vector<std::complex<double>> map_response(const ident::ValveMap& map,
                                                             const identify::FitTable& input,
                                                             const std::vector<double>& lines_Hz);

}  // namespace eha::report
