// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Fits structures that the models of a table may lack to the record, where no accepted model makes up for them:
///   each grey box that the residual of a model speaks for (ident::grey_box_to_try), or that the first model of the
///   table may lack (ident::grey_box_left_to_try);
///   where the first model misses a part of the plant, io with more poles and zeros, as of two masses, unless a valve's
///   map is what makes it that good;
///   where nothing of that explains it, simple structures behind an input that saturates (trial_of_saturation());
///   where the gain depends on the level, or a grey box explains it, behind a power of the input (trial_of_power()).
/// Notes on the models that one holds (kGreyBoxHolds, ident::note_explanation()) where it is accepted and errs clearly
/// less than they do, and takes back an end stop, a jump or a change of gain that it does without. The verdicts then
/// advise it. The models stay the same, and so does the recommended one. Nothing by the paper's procedure, of rows that
/// are too slow, of a record in closed loop, and for records of more than 200 000 rows. Cost: a fit of each structure
/// where a model asks for it; else none.
/// @param progress  told which structure is tried, and why
void try_other_structures(const IdentificationTask& task, Identification& identification,
                          const Progress& progress = {});

}  // namespace eha::identify
