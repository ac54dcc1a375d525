// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// Fits a grey box by output error: starts from the linear form's own fit, then Levenberg-Marquardt from each start of
/// the kind with derivatives by differences, to the end from the three best. With options.most_mse a search ends where
/// it will not come below that, were it to fall on as it did. Positive values are searched by their logarithms.
/// initial_output is estimated, input_bias unless it is the reference of the kind (then minus the mean input of the
/// estimating rows), and the states at t = 0 where the kind or the request asks for them. Requests hold, start or free
/// a parameter; bounds of requests are refused. Intervals are those of standard errors. A time constant of less than
/// some tenth of a row is held at that: the record does not show it.
/// @param known  fitted to the same rows; one of the kind is the only start, one of its linear form gives the starts
/// @throws DataError    as fit(); the search found no finite model, or none below options.most_mse
/// @throws ConfigError  a request makes no sense; the paper's procedure is asked
/// Cost: the fit of the linear form and, for each start, some 30 simulations a parameter.
[[nodiscard]] FitResult fit_grey_box(const PreparedRecord& prepared, const StructureOptions& asked,
                                     const FitOptions& options, const Executor& executor,
                                     const std::vector<Model>& known = {});

}  // namespace eha::ident
