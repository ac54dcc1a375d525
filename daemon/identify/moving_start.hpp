// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Of a record that begins in motion nobody knows the input before its first row, which acts until the dead time is
/// over, and a pole and a zero more take that in. Where the recommended model has such terms, and a dead time or a zero
/// that stands for one, or none is recommended, fits again to the rows behind the dead time, before which the output
/// counts for nothing, and takes that fit where it recommends a model of fewer parameters. The task then leaves out
/// those rows, and says so in its remarks.
/// @returns the sentence for the user; empty where nothing was changed
/// Cost: none without such a model, else the same fit once more.
[[nodiscard]] std::string leave_out_moving_start(IdentificationTask& task, Identification& identification,
                                                 const FitTask& fit);

/// Of a record whose input keeps its first value over 30 % of the rows and more the part that estimates may hold hardly
/// any motion. Where no model is recommended, fits again to the rows from shortly before the input moves, and takes
/// that fit where it recommends one. The task then leaves out the rest, and says so in its remarks.
/// @returns the sentence for the user; empty where nothing was changed. Cost: none beside a model, else the fit once
/// more.
[[nodiscard]] std::string leave_out_resting_start(IdentificationTask& task, Identification& identification,
                                                  const FitTask& fit);

}  // namespace eha::identify
