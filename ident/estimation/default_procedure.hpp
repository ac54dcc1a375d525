// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"

namespace eha::ident {

/// Output error of a structure on a record, as fit() promises it: prepare the record, search each variant of what came
/// before t = 0 on coarse records, follow the best optima on the whole one, choose, report.
/// @param record  checked: finite, of one length, moving
[[nodiscard]] FitResult fit_by_default(const Record& record, const StructureOptions& asked, const FitOptions& options,
                                       const Executor& executor);

/// Fewest rows that a fit estimates from.
inline constexpr Eigen::Index kFewestRows = 20;

}  // namespace eha::ident
