// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::acquisition {

/// A sensor that has slipped by more in all trips, and a ruler may differ by so much from one that may have [in].
inline constexpr double kMostSlip_in = 0.05;

}  // namespace eha::acquisition
