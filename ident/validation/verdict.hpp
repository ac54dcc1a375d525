// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit_options.hpp"
#include "ident/model/model.hpp"

namespace eha::ident {

/// Chosen above the 0.2 % of a 50 s run that the loop's abort limits allow.
inline constexpr double kMostInterpolated_percent = 1.0;

/// Holds a fitted model against the experiment's limits and against what its own record determines.
/// Rejects for: a fit that did not converge; an R2 below or an error above its limit; a model that is unstable or too
/// near to it; a free order whose standard error exceeds 0.15 or whose term costs less than 10 of AR-BIC to leave out;
/// a record of which more than kMostInterpolated_percent was not measured, as an interpolated sample agrees with any
/// smooth model. A model that is not rejected is good when it passes the rest too, else usable: the 95 % interval of
/// each free coefficient excludes 0 (what it is depends on which coefficient is 1, so this does not reject), each
/// residual test at 1 %, and at most 5 % of the validating samples with an input beyond the estimating ones. Every
/// criterion that applied is listed with value and limit; each that failed has a sentence, those of a rejection first.
/// A model without validation (the whole record estimated) is judged by its estimation figures, and a sentence says so.
/// @param interpolated_percent  rows of the record whose output was not measured [% of its rows]
/// Never throws on a model's content; a figure that is not finite does not pass.
[[nodiscard]] Verdict judge(const Model& model, const AcceptanceLimits& limits, double interpolated_percent = 0.0);

}  // namespace eha::ident
