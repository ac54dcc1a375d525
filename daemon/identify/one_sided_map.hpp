// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Fits again, from where they were found and with no gain below the dead band, the maps that are rejected for the sign
/// of that gain alone, which the record does not show: of a pump the input reaches that side with its noise. A fit that
/// is accepted takes the place of the rejected one, and the recommendation is made anew. Nothing by the paper's
/// procedure and of a record in closed loop. Cost: a local fit of each such map; else none.
void hold_one_sided_maps(const IdentificationTask& task, Identification& identification);

}  // namespace eha::identify
