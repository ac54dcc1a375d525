// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/display_unit.hpp"

namespace eha::cli {

/// Draws the rod between its limits, "0.150 [====------#-----------====] 5.750": '#' is the rod, '=' is beyond 80 % of
/// the way to a limit.
[[nodiscard]] std::string travel_bar(double displacement, double lowest, double highest);
/// Draws the bar only, "[==----#----==]". @param width  in characters between the brackets, odd
[[nodiscard]] std::string short_bar(double displacement, double lowest, double highest, int width);

/// A line of `eha read` and `eha status`, name and text: rod, sensor, lines, and a warning near a limit.
struct NamedText {
  std::string name;
  std::string text;
};

/// @param rod    the member `rod` of ehad-protocol(7)
[[nodiscard]] std::vector<NamedText> rod_lines(const nlohmann::ordered_json& rod, const DisplayUnit& unit);

/// Travel limits of the rod.
struct Travel {
  double lowest_in = 0.0;
  double highest_in = 0.0;
};

/// "2.541 mm beyond the upper travel limit of 146.050 mm"; empty for a place within the limits.
[[nodiscard]] std::string beyond_limit(double place_in, const Travel& travel, const DisplayUnit& unit);

/// Returns `eha goto` to mid-travel. From a place beyond a limit the command asks whether the rod is there.
[[nodiscard]] std::string goto_middle(const Travel& travel, const DisplayUnit& unit);

/// The same for a rod near a limit or beyond it; empty elsewhere, and if its position is unknown.
[[nodiscard]] std::string way_to_middle(const nlohmann::ordered_json& rod, const DisplayUnit& unit);

/// Joins the lines to one text, with the names in a column.
[[nodiscard]] std::string aligned(const std::vector<NamedText>& lines);

}  // namespace eha::cli
