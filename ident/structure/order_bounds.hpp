// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::ident {

// Bounds of a free order, far beyond those of a real rig; they keep powers finite.
inline constexpr double kLowestOrder = 0.05;  ///< of a denominator term
inline constexpr double kHighestOrder = 3.0;

}  // namespace eha::ident
