// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/display_unit.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// A subject with its output in the unit, for people to read. The manifest stays as it is.
[[nodiscard]] Subject in_unit(Subject subject, const DisplayUnit& unit);

}  // namespace eha::report
