// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/acquisition/command_source.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/error.hpp"

namespace eha::acquisition {
TableSource::TableSource(std::span<const double> table_V, std::uint32_t repetitions)
    : table_V_(table_V), repetitions_(repetitions) {
  require(!table_V.empty(), "the excitation is empty; give the experiment a duration");
  require(std::all_of(table_V.begin(), table_V.end(), [](double u) { return std::isfinite(u); }),
          "the excitation holds a voltage that is not finite");
  require(repetitions >= 1 && repetitions <= std::numeric_limits<std::uint16_t>::max(),
          "repetitions: expected 1 to 65535, got " + std::to_string(repetitions));
  require(table_V.size() <= kMostRows / repetitions, "the experiment is longer than 2147483647 ticks");
}

}  // namespace eha::acquisition
