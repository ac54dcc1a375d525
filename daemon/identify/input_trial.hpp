// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Columns of a file that are not what the plant got and gave.
struct WrongInput {
  std::string sentence;      ///< what is wrong with it, the figures, and what to do
  std::string options = {};  ///< of `eha fit`, which mend it, "--input-late 2"; empty: none does
  bool are_times = false;    ///< the columns are right, and their rows were moved although they had been sampled evenly
};

/// Asks whether input and output are exchanged (exchanged_fit()). Else fits the best of the simple models again behind
/// an input as it may have been: some rows earlier, without the part where it froze (ident::frozen_input()), and, where
/// it stands exactly at its ends, going on beyond them (of_clipped_input()); of rows that were moved, as if they
/// had been sampled evenly. An input that is right errs more that way, whatever else its model lacks.
/// @returns what errs clearly less than every given model and, of a shift, than an input that is straight between the
/// rows; none of a run, whose input is known, of a record in closed loop or, of a shift, with gaps, where the first
/// model passes every check, and for records of more than a million rows. Cost, none where the model passes: of two
/// models each, four local searches on 20 000 rows, up to 16 where a shift helps, four more where it may be clipped,
/// and two on the whole record where it may have frozen.
[[nodiscard]] std::optional<WrongInput> wrong_input(const Source& source, const IdentificationTask& task,
                                                    const Identification& identification,
                                                    const Progress& progress = {});

/// A wrong input by the record alone, before any fit: the input keeps one value over a tenth of the record and more
/// while the output goes on (ident::frozen_input()), or is plain noise in which the output has no part. None of a run
/// and of a record in closed loop. Cost O(N), below 0.1 s of a million rows.
[[nodiscard]] std::optional<WrongInput> lost_input(const Source& source);

/// Judges the models anew, each of which is rejected for it unless it is the times that are wrong, and chooses again.
void reject_for(const WrongInput& wrong, const IdentificationTask& task, Identification& identification);

}  // namespace eha::identify
