// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/replay/twin_calibration.hpp"

namespace eha::replay {

/// Writes the text of a rig file with the calibrated values in its table `[sim]`, each with its interval as a comment;
/// adds a key that the table lacks at its head. Keeps all other text.
/// @param text    of a rig file with `[sim]`
/// @param origin  the record, for the comment at the head
[[nodiscard]] std::string twin_text(std::string_view text, const Calibration& calibration, std::string_view origin);

}  // namespace eha::replay
