// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/display_unit.hpp"
#include "daemon/tune/tune.hpp"

namespace eha::tune {

/// "PID".
[[nodiscard]] std::string name_of(ident::FeedbackKind kind);

/// Returns the best candidate of each kind that does not hunt, all with the same load step at the valve.
/// @param fractional_gain  of ident::gain_of_fractional_orders(); none: not compared
[[nodiscard]] std::vector<ComparedKind> kinds_compared(const std::vector<Candidate>& candidates,
                                                       const ident::AxisPlant& plant,
                                                       std::optional<double> fractional_gain);

/// Titles of kind_rows(), lengths in the unit.
[[nodiscard]] std::vector<std::string> kind_titles(const DisplayUnit& unit);
/// Explanation of the titles.
inline constexpr const char* kKindNote =
    "Following and rest: short trials on four drawn rigs. After a load: RMS error of the linear loop after the same "
    "step of "
    "load, over the PID's; \"stays\" without an integral. Lasting: what remains of a load that would move the rod so "
    "fast.";

/// Returns rows for display, one a kind; none if only one kind was tried.
[[nodiscard]] std::vector<std::vector<std::string>> kind_rows(const std::vector<ComparedKind>& kinds,
                                                              const DisplayUnit& unit);

}  // namespace eha::tune
