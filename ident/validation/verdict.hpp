// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit_options.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// Chosen above the 0.2 % of a 50 s run that the loop's abort limits allow.
inline constexpr double kMostInterpolated_percent = 1.0;

/// Holds a fitted model against the experiment's limits. Rejects a fit that did not converge, an R2 below its limit, an
/// error above its limit, a model that is unstable or too near to it; each with a sentence that gives value and limit.
/// Further sentences are notes that do not reject: residual correlated with past input, residual not white, no
/// validation.
/// A model without validation (the whole record estimated) is judged by its estimation figures, and a sentence says so.
/// Rejects every model of a record of which more than kMostInterpolated_percent was not measured: an interpolated
/// sample agrees with any smooth model.
/// @param interpolated_percent  rows of the record whose output was not measured [% of its rows]
/// Never throws on a model's content; a figure that is not finite does not pass.
[[nodiscard]] Verdict judge(const Model& model, const AcceptanceLimits& limits, double interpolated_percent = 0.0);

}  // namespace eha::ident
