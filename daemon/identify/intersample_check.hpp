// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// What a record tells of its input between the rows.
struct BetweenRows {
  std::string seen;            ///< how far it moves, and what straight lines make of the error; one clause
  std::string undecided = {};  ///< what half a row changes, where the error does not tell; else empty
  bool is_straight = false;    ///< the error of straight lines is so much less that nobody need be asked
};

/// Whether the input of a file was taken as held between its rows although the record contradicts it: the recommended
/// model, fitted again both ways, has a clearly lower AR-BIC with an input that is straight between the rows; or one
/// without its zero and dead time, which may have stood for half a row alone, has a lower one so. Where a
/// zero or dead time has taken up the half row, and steps do not describe the record clearly better than a smooth input
/// (lines of a fast input err as steps do), it says what half a row changes.
/// @returns nothing where the input is held, or as good as held, and for records of more than a million rows
/// Cost: three to five fits from a known model on ident::kPartsOfARow times the rows.
[[nodiscard]] std::optional<BetweenRows> input_between_rows(const Source& source, const IdentificationTask& task,
                                                            const Identification& identification);

/// Whether the files among some records, each with a model fitted to it as held, show together that their input is
/// straight between the rows, as BetweenRows::is_straight does of one: one answer for all, so that they are fitted
/// alike. Records of runs, and inputs that hardly move within half a row, have no say.
/// @param models  one a record, with the structure that it was fitted with
/// Cost: two fits a file from a known model on ident::kPartsOfARow times the rows.
[[nodiscard]] bool are_straight(const std::vector<Source>& sources, const std::vector<const ident::Model*>& models);

/// The advice of what input_between_rows() found, with the command that fits the record with a straight input.
[[nodiscard]] std::string advice_of(const BetweenRows& found, const std::string& command);

}  // namespace eha::identify
