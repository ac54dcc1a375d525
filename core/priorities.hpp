// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha {

/// SCHED_FIFO priority of the guard: above the loop and above any thread that could starve the loop. ehad.service
/// allows it (LimitRTPRIO).
inline constexpr int kGuardPriority = 95;

/// The loop's highest: the guard must be able to preempt it.
inline constexpr int kHighestLoopPriority = 90;

}  // namespace eha
