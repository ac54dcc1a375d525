// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "daemon/identify/identification.hpp"
#include "daemon/identify/trial.hpp"
#include "ident/model/model.hpp"

namespace eha::identify {

/// The model of a plant behind an input that saturates: the structure that errs least with the input between limits.
/// None that holds. Cost: some ten local fits for each of three structures.
[[nodiscard]] std::optional<Trial> trial_of_saturation(const IdentificationTask& task,
                                                       const Identification& identification, const ident::Model& first);

/// The model of a plant whose gain is curved: the structure that errs least behind a power of the input,
/// sign(u) |u|^p, as of the flow through an orifice (p = 0.5) or past a notched spool (p > 1). None that holds, and
/// none where the input is too even to tell p from 1. Cost as above.
[[nodiscard]] std::optional<Trial> trial_of_power(const IdentificationTask& task, const Identification& identification,
                                                  const ident::Model& first);

/// The model of a plant with a play, at its input (a spool or linkage with hysteresis) or between it and its sensor (a
/// loose coupling), whichever errs less. None that holds. Cost: some 28 local fits of each structure.
[[nodiscard]] std::optional<Trial> trial_of_play(const IdentificationTask& task, const Identification& identification,
                                                 const ident::Model& first);

}  // namespace eha::identify
