// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <string_view>

#include "hal/rig.hpp"

namespace eha::acquisition {

/// What the lines of a rig show while it is not driven, and after which somebody must arm it anew.
enum class CircuitAtRest {
  sound,
  emergency_stop,  ///< its circuit is open, or was
  contact,         ///< the auxiliary contact is closed although the enable line is off
};

/// A reading that fails sooner is tried again at the next moment: one that took longer leaves out those of a second.
inline constexpr std::chrono::milliseconds kSlowFailure{20};

/// Time after the enable line went off at which its contact must be open.
[[nodiscard]] std::chrono::duration<double> longest_drop_out(const hal::RigCapabilities& rig) noexcept;

/// Looks at a reading of a rig that is not driven, and reads once more where a line is wrong: interference in one
/// reading is none. A call that fails counts as sound.
/// @param since_off  since the enable line went off; a contactor takes its time to drop out
[[nodiscard]] CircuitAtRest circuit_at_rest(hal::Rig& rig, const hal::RigReading& reading,
                                            std::chrono::duration<double> since_off) noexcept;

/// "the emergency-stop circuit was opened while nothing was driven"; empty where it is sound.
[[nodiscard]] std::string_view sentence_of(CircuitAtRest circuit) noexcept;

}  // namespace eha::acquisition
