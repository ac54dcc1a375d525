// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// The compared rows of a record and a model's output there, N samples each.
struct ComparedRows {
  const Eigen::VectorXd& time_s;
  const Eigen::VectorXd& input;
  const Eigen::VectorXd& measured;
  const Eigen::VectorXd& simulated;
};

/// Finds a rod on an end stop, or one that does not answer (unanswered()): the output of an integrating plant stays
/// within its noise of its greatest or least value, while the model's output goes beyond it and while other rows with
/// the same input, elsewhere, move. Of any plant also an output that stays there for the last 30 % of the rows or more,
/// while the input goes over half its range.
/// @returns none if no such stay is found, or on fewer than 60 rows.
/// Cost O(N log N).
[[nodiscard]] std::optional<EndStop> end_stop(const ComparedRows& rows);

/// The options that keep the stretch without a stay in which the output moves most, "--from 12.5 --to 84.9"; empty: it
/// moves in none.
[[nodiscard]] std::string cut_options(const EndStop& stop);

/// Finds the greatest sudden lasting change of the error (measured less simulated): more than eight times the usual
/// change within five rows, across rows that were not measured in the time of so many. Up to four others may be like
/// it, as where rows are missing at several places, if each is as sudden and lasting. Where the model's motion turns
/// back, dry friction and play make such steps: there a change counts only if it is twice the greatest at the other
/// turns, of three at least.
/// @returns none on fewer than 60 rows. Cost O(N log N).
[[nodiscard]] std::optional<ErrorJump> error_jump(const ComparedRows& rows);

/// Finds the stretch of a record, or the greatest of up to three, that holds most of the error: as where rows or the
/// input were lost of a plant that comes to rest, so that the error is back afterwards.
/// @returns none where such stretches take more than a tenth of the rows or hold less than four fifths of the squared
/// error, and on fewer than 60 rows. Cost O(N log N).
[[nodiscard]] std::optional<ErrorJump> error_burst(const ComparedRows& rows);

/// Times at which to cut a record so that a jump lies in neither part.
struct CutBeside {
  double to_s = 0.0;    ///< end of the part before
  double from_s = 0.0;  ///< start of the part after
};

/// Some compared rows on each side of the jump, whose place a decimation's filter blurs, as times of few digits.
/// @param compared_step_s  none: unknown
[[nodiscard]] CutBeside cut_beside(const ErrorJump& jump, std::optional<double> compared_step_s);

/// "--to 129.9 or --from 130.06".
[[nodiscard]] std::string cut_options(const CutBeside& cut);

/// "error jumps by 0.3 mm at about 24 s"; of a burst "error is up to 14 mm from about 24 to 26 s, and far less
/// elsewhere". @param unit  of the output
[[nodiscard]] std::string jump_text(const ErrorJump& jump, const std::string& unit);

/// What makes such a jump, a clause: "the sensor slipped or froze, ...".
inline constexpr std::string_view kMakesAJump =
    "the sensor slipped or froze, the load changed or rows are missing there";

/// The same of a burst.
inline constexpr std::string_view kMakesABurst =
    "rows or the input were lost there, the sensor failed for a while, or something else moved the output";

}  // namespace eha::ident
