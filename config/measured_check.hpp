// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <string>

#include "config/rig_config.hpp"
#include "core/journal_block.hpp"

namespace eha::config {

/// Returns a sum over the measured numbers of [following]: gains, null, dead band and their uncertainties, to six
/// digits. Another digit in one of them gives another sum. Limit and pressure delay are no part of it: an owner sets
/// them.
[[nodiscard]] inline std::uint32_t measured_check_of(const Following& following) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const std::string text =
      fmt::format("{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g} {:.6g}", following.gain_positive_in_per_V_s,
                  following.gain_negative_in_per_V_s, following.null_V, following.dead_band_V,
                  following.null_uncertainty_V.value_or(kUnknown), following.dead_band_uncertainty_V.value_or(kUnknown),
                  following.gain_uncertainty_percent.value_or(kUnknown));
  return journal::Crc32c().add(text.data(), text.size()).value();
}

/// Whether the numbers are those that one characterisation wrote. False without a sum.
[[nodiscard]] inline bool is_as_measured(const Following& following) {
  return following.measured_check && *following.measured_check == measured_check_of(following);
}

}  // namespace eha::config
