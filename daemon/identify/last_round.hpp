// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/identify/identification.hpp"
#include "daemon/identify/source.hpp"

namespace eha::identify {

// The experiment that follows an identification. It is written into the identification, never played.

/// Ends the rounds of an identification without an accepted model: an experiment designed for the parameter for which
/// a model is rejected, else a longer one. Cost: a design, seconds; `progress` may be empty.
void end_with_experiment(const Source& source, const IdentificationTask& task, const Progress& progress,
                         Identification& identification);

/// Adds the longer experiment where the record is too short to judge the recommended model. Cost: none to speak of.
void add_longer_experiment(const Source& source, const IdentificationTask& task, Identification& identification);

}  // namespace eha::identify
