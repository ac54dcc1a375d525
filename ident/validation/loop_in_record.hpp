// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "ident/record.hpp"

namespace eha::ident {

/// A controller that makes the input of a record from its output.
struct LoopInRecord {
  double correlation = 0.0;  ///< of v and w
  bool is_quiet = false;     ///< hardly any of the input comes round it, so that a model may well be exact
};

/// Whether a controller makes the input of a record from its output: of row k both
///   y(k) = sum_i a_i y(k - i) + b_i u(k - i) + v(k),   u(k) = sum_i c_i y(k - i) + d_i u(k - i) + w(k),  i = 1 .. 6
/// are predicted from the rows before, and what moves the output beside them, v, is in the input's w of the same row at
/// once, against the plant's gain. Needs no model of the plant, and no reference. A loop whose delay is a row or more
/// is not seen here (see ResidualTests::future_input). A plant that answers in the same row may do so against its gain,
/// too. What is left of v without its part in w is noise then, which the input of a loop answers in the rows that
/// follow, and one that was played does not. Without anything left (noise alone goes round the loop, its reference at
/// rest) a loop is seen only where no gain is. Where the input is smooth or held, as its own past predicts it but for
/// the steps of a reference, v and w are those of the rows between the steps: such a loop is quiet, and has to show
/// more, as what is not linear or between rows is in them as well.
/// @returns none where v and w do not correlate beyond -0.3 against a positive gain (0.3 against a negative one) and
/// far beyond chance. Cost O(N); of long records the first 20 000 rows. Soderstrom, Stoica, System Identification
/// (1989), ch. 10.
[[nodiscard]] std::optional<LoopInRecord> loop_in_record(const Record& record);

/// Correlation of input and output in the same row; 0 where one of them stands. A controller without noise or delay of
/// its own, whose reference stands, makes it -1 or 1, and no model tells such a loop from a plant that answers at once.
/// Cost O(N).
[[nodiscard]] double same_row_correlation(const Record& record);

}  // namespace eha::ident
