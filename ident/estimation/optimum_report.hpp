// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/validation/residual_tests.hpp"

namespace eha::ident {

/// What a fit has, besides its optimum, to be reported.
struct FitAtItsEnd {
  const PreparedRecord& prepared;
  const ComparedRecord& compared;
  const FitOptions& options;
  const Executor& executor;
  const StructureOptions& given;  ///< of the caller
  const StructureOptions& asked;  ///< the same with what the record's start decides
  const Parametrisation::Scale& scale;
  bool rests_before;  ///< the record is known to begin at rest
  const WorkByStage& work;
};

/// The model of an optimum with intervals and, where the options want everything, what complete_report() adds.
/// Cost: profiles cost as ProfileSearch says.
[[nodiscard]] FitResult report_of(const LocalOptimum& chosen, const FitAtItsEnd& fit);

/// Adds Bode curve, validation and noise to a report of the estimation alone. Cost: a simulation for each test.
/// @param result  of report_of()
void complete_report(FitResult& result, const PreparedRecord& prepared, Effects effects);

/// Whether a report has what complete_report() adds.
[[nodiscard]] bool is_complete(const FitResult& result);

}  // namespace eha::ident
