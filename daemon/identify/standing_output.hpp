// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "ident/record.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {

/// A record that stands still but for a moment.
struct StandingOutput {
  std::string sentence;
  ident::RecordFacts::Piece piece;  ///< the moment, and how long the output has to move
};

/// Whether the output stands at its least or its greatest value to the bit in nine rows of ten, with a few values of a
/// sensor in all: any model follows such a step, with any gain. None where it moves. Cost O(N).
[[nodiscard]] std::optional<StandingOutput> standing_output(const ident::Record& record);

}  // namespace eha::identify
