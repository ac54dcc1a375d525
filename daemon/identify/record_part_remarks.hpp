// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"
#include "ident/estimation/judging_part.hpp"

namespace eha::identify {

// What is said of the parts of a record that estimate and judge.

/// Of a record that holds too little motion.
struct PieceRemark {
  std::string sentence;                                 ///< with what to record
  std::optional<ident::RecordFacts::Piece> piece = {};  ///< none where a longer record tells no more
};

/// What to say of a record whose estimating part holds less than two periods of the input's fastest motion: many curves
/// follow such a piece. A lone pulse is one, and may still tell the plant. None where it holds more. Cost: the spectrum
/// of that part.
[[nodiscard]] std::optional<PieceRemark> piece_remark(const IdentificationTask& task);

/// Why another share of the record estimates than the default.
[[nodiscard]] std::string other_split_remark(const ident::CoveringSplit& other, const IdentificationTask& task);

}  // namespace eha::identify
