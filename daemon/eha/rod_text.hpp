// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/display_unit.hpp"

namespace eha::cli {

/// The rod between its limits, "0.150 [====------#-----------====] 5.750": '#' is the rod, '=' is beyond 80 % of the
/// way to a limit.
[[nodiscard]] std::string travel_bar(double displacement, double lowest, double highest);
/// Only the bar, "[==----#----==]". @param width  in characters between the brackets, odd
[[nodiscard]] std::string short_bar(double displacement, double lowest, double highest, int width);

/// A name and what it is, one a line of `eha read` and `eha status`: rod, sensor, lines, and a warning near a limit.
struct NamedText {
  std::string name;
  std::string text;
};

/// @param rod    the member `rod` of ehad-protocol(7)
[[nodiscard]] std::vector<NamedText> rod_lines(const nlohmann::ordered_json& rod, const DisplayUnit& unit);

/// The lines as one text, the names in a column.
[[nodiscard]] std::string aligned(const std::vector<NamedText>& lines);

}  // namespace eha::cli
