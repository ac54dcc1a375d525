// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "daemon/identify/identification.hpp"

namespace eha::identify {

/// Fits each grey box that the residual of a model speaks for (ident::grey_box_to_try), or that the first model of the
/// table may lack (ident::grey_box_left_to_try) and no accepted model makes up for, to the record, and notes on the
/// models that it holds (ident::kGreyBoxHolds) where it is accepted and errs clearly less than they do. Their verdicts
/// then advise it. The models stay the same, and so does the recommended one.
/// Nothing by the paper's procedure, and for records of more than 200 000 rows.
/// Cost: a fit of one grey box where a model asks for it; else none.
void try_grey_boxes(const IdentificationTask& task, Identification& identification);

}  // namespace eha::identify
