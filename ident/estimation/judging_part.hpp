// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/fit_options.hpp"
#include "ident/record.hpp"

namespace eha::ident {

/// Whether input and output rest in the part of the record that would judge a
/// model while both move in the part that estimates, as after a single step: an
/// R2 there is one of noise. A rod that runs at a constant input does not rest.
/// False where the options keep nothing for validation, or the record is too
/// short to be fitted. Cost O(N).
[[nodiscard]] bool judging_part_rests(const Record &record,
                                      const FitOptions &options);

} // namespace eha::ident
