// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "ident/estimation/fit.hpp"

namespace eha::ident {

/// The structure of the paper that this one is by its terms: `io` with two poles and no zero, or `fo`; nothing for any
/// other. Delay and requests do not count.
[[nodiscard]] std::optional<Structure> published_structure(const Structure& structure);

/// The published procedure to the letter, for comparison: every Nth sample kept as if the input were held that long,
/// the first seconds dropped, y less its first value, zero history at the start of each part, Grunwald-Letnikov
/// simulation, Levenberg-Marquardt. Stage 1 frees K, a2, a1, a0 at orders 2, 1, 0; stage 2, for structure `fo`, frees
/// n2, n1, n0 and b0 (not below 0) from 1.8, 0.9, 0, 0 and nothing else. What it neglects is written into the model's
/// provenance. Mhd Yusof et al., Int. J. Smart Sensing and Intelligent Systems 9(1), 2016.
/// @throws ConfigError  not a published structure, or a delay or request beside it
[[nodiscard]] FitResult fit_by_paper(const Record& record, const StructureOptions& asked, const FitOptions& options);

}  // namespace eha::ident
