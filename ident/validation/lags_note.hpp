// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What lags of the residual's correlations outside their bounds mean beside the grade, in one sentence or two; empty
/// where no more are outside than chance puts there.
/// @param model  with its validation, whose score is the one that was judged
[[nodiscard]] std::string lags_note(const Model& model, const Verdict& verdict);

}  // namespace eha::ident
