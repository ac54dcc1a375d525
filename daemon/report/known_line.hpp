// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "daemon/plot/figure.hpp"
#include "daemon/report/subject.hpp"

namespace eha::report {

/// Adds the curve of a model over frequency: its line within the usable band, and faint beyond, where no record tests
/// it. Of a verdict without a band all is faint; of a model without a verdict nothing is known of either.
/// @param label  in the key; empty: of a panel whose key another one has
void add_known_line(plot::Panel& panel, const std::string& label, const ReportedModel& reported,
                    const std::vector<double>& frequency_Hz, const std::vector<double>& values, int style);

}  // namespace eha::report
