// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/tune/controller_page.hpp"

namespace eha::tune {

inline constexpr const char* kOvershoot = "overshoot of a step";  ///< figure of a trial that has one

/// "P controller "axis": greatest error in the trapezoids 0.00106 in, error at rest 0.001 in, promise kept": what was
/// reached, on the rig or in the trials, then the promise.
[[nodiscard]] std::string headline(const ControllerSubject& subject);

/// The box at the head of a controller's page, as HTML: what the controller achieves, its margins, what limits it, what
/// to do next. Of a trial on a rig: what of the promise is not kept, too.
[[nodiscard]] std::string answer_box(const ControllerSubject& subject);

}  // namespace eha::tune
