// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "config/rig_config.hpp"
#include "hal/backends/backend.hpp"

namespace eha::config {

/// Why a rig that moves a machine plays nothing but [characterise], and what to do.
inline constexpr std::string_view kNeedsFollowing =
    "no [following] in the rig file: nothing but `eha characterise` moves a machine whose valve is not known, because "
    "a dead sensor would be found late and the rod may meet its end stop; run it with somebody "
    "at the emergency stop and install the rig file that it writes";

/// What a simulated rig without [following] lacks, and what to do.
inline constexpr std::string_view kNotFollowed =
    "no [following] in the rig file: experiments are not rehearsed, and a rod that does not follow is found late; "
    "`eha characterise` measures the valve and writes the rig file with it";

/// Whether kNeedsFollowing holds for a rig.
[[nodiscard]] inline bool needs_following(const RigConfig& rig) {
  return hal::moves_machine(rig.backend) && !rig.limits.following;
}

}  // namespace eha::config
