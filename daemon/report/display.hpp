// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/display_unit.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// Converts a subject's output to the displayed unit. Leaves the manifest unchanged.
[[nodiscard]] Subject in_unit(Subject subject, const DisplayUnit& unit);

}  // namespace eha::report
