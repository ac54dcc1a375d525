// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "daemon/identify/source.hpp"

namespace eha::identify {

/// What comparing many rows costs, and the decimation that keeps what the input can show.
struct SizeHint {
  std::string sentence;
  bool is_grave = false;  ///< minutes on any machine, not on a slow one alone
};

/// @param source      its rows, not the parts of them that a straight input makes
/// @param decimation  of the rows
/// @param command     with --decimate N added; none: it is named alone
/// @returns none where few rows are compared. Cost: one Fourier transform of the input
[[nodiscard]] std::optional<SizeHint> size_hint(const Source& source, int decimation,
                                                const std::function<std::string(int)>& command = {});

}  // namespace eha::identify
