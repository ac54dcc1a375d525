// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/display_units.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace eha::cli {
namespace {

struct Length {
  std::string_view name;
  double metres;
};
constexpr std::array kLengths = std::to_array<Length>({{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}});

std::optional<double> metres_in(std::string_view unit) {
  const auto found = std::find_if(kLengths.begin(), kLengths.end(), [&](const Length& l) { return l.name == unit; });
  return found == kLengths.end() ? std::nullopt : std::optional(found->metres);
}

}  // namespace

std::vector<std::string> display_units() {
  std::vector<std::string> names;
  for (const Length& length : kLengths) names.emplace_back(length.name);
  return names;
}

std::string DisplayUnit::of(const std::string& unit) const {
  return metres_in(unit) && metres_in(name_) ? name_ : unit;
}

double DisplayUnit::factor(std::string_view unit) const {
  const auto from = metres_in(unit);
  const auto to = metres_in(name_);
  return from && to ? *from / *to : 1.0;
}

}  // namespace eha::cli
