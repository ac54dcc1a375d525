// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What lags of the residual's correlations outside their bounds mean beside the grade, in a few sentences, and why the
/// test of all lags together may find an input that no single lag shows; empty where both find nothing.
/// @param model  with its validation, whose score is the one that was judged
[[nodiscard]] std::string lags_note(const Model& model, const Verdict& verdict);

}  // namespace eha::ident
