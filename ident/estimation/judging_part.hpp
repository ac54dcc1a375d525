// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "ident/fit_options.hpp"
#include "ident/record.hpp"

namespace eha::ident {

/// Whether input and output rest in the part of the record that would judge a model while both move in the part that
/// estimates, as after a single step: an R2 there is one of noise. A rod that runs at a constant input does not rest.
/// False where the options keep nothing for validation, or the record is too short to be fitted. Cost O(N).
[[nodiscard]] bool judging_part_rests(const Record& record, const FitOptions& options);

/// A share of the record that estimates, and why the one of the options would not do.
struct CoveringSplit {
  double share = 0.0;
  double lowest = 0.0;  ///< input of the part that would estimate [input unit]
  double highest = 0.0;
  double lowest_of_rest = 0.0;  ///< of the part that would judge
  double highest_of_rest = 0.0;
};

/// The least share of 0.6, 0.7, 0.8 and 0.9 whose input lets a valve's map be estimated where that of the options does
/// not: on either side of its median it reaches half of what the record's reaches, and of a staircase it has two levels
/// where the record has. None after which judging_part_rests(). None where the options' share does, or none of these.
/// Cost O(N log N).
[[nodiscard]] std::optional<CoveringSplit> covering_split(const Record& record, const FitOptions& options);

}  // namespace eha::ident
