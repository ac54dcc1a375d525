// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/valve/valve_sheet.hpp"

// The parts of valve_sheet().

namespace eha::ident {

/// Fills null, dead band, gains, hysteresis, creep and the blocks from the plan's triangles.
/// @param lag_s  lag of the velocity behind the command
/// @throws DataError  as valve_sheet()
void measure_static_part(const Record& record, const SheetPlan& plan, double lag_s, ValveSheet& sheet);

/// Fills the responses, natural frequency, damping and lag from the plan's sines. Precondition: the static part.
/// Leaves the lag unchanged if the sines do not determine it.
void measure_dynamic_part(const Record& record, const SheetPlan& plan, ValveSheet& sheet);

/// Returns the standard deviation of the sensor about a parabola in the plan's rest.
[[nodiscard]] double noise_at_rest(const Record& record, const SheetPlan& plan);

}  // namespace eha::ident
