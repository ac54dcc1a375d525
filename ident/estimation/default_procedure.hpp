// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"
#include "ident/estimation/optimum_report.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// Output error of a structure on a record, as fit() promises it: prepare the record, search each variant of the
/// history before t = 0 on coarse records, refine the best optima on the whole one, choose, report.
/// @param prepared  of a checked record: finite, of one length, moving; and of the same options
/// @param known     models fitted to the same rows: those inside the structure are starts, and the result's cost is at
///                most 0.1 % above theirs
[[nodiscard]] FitResult fit_by_default(const PreparedRecord& prepared, const StructureOptions& asked,
                                       const FitOptions& options, const Executor& executor,
                                       const std::vector<Model>& known);

/// A model that a fit without profiles gave, with intervals by profile; `work` is that of the profiles.
/// @param fitted  by fit_by_default()
[[nodiscard]] FitResult with_profiles(const PreparedRecord& prepared, const FitResult& fitted,
                                      const FitOptions& options, const Executor& executor);

/// Fewest rows that a fit estimates from.
inline constexpr Eigen::Index kFewestRows = 20;

}  // namespace eha::ident
