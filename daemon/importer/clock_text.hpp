// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>

namespace eha::importer {

/// Seconds of a date and time or a time of day in digits: "2024-03-01 10:00:00.25", "2024-03-01T10:00:00", "01.03.2024
/// 10:00:00,25", "03/01/2024 10:00:00", "10:00:00.25"; none for other text. No time zone applies. Only for differences
/// within a day: whether 01.03. is in January or in March does not matter then.
[[nodiscard]] std::optional<double> clock_seconds(std::string_view text);

}  // namespace eha::importer
