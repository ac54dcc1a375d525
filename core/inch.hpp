// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha {

inline constexpr double kMetrePerInch = 0.0254;  ///< exactly

}  // namespace eha
