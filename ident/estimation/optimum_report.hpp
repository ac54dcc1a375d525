// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// Results that a fit computes in addition to the estimate.
enum class Reported {
  everything,
  estimation,  ///< not the Bode curve and the validation: of a model that only serves others
};

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

/// The model of an optimum with intervals, Bode curve and, where `what` wants everything, validation and noise.
/// Cost: of everything a simulation for each test and frequency; profiles cost as ProfileSearch says.
[[nodiscard]] FitResult report_of(const LocalOptimum& chosen, const FitAtItsEnd& fit, Reported what);

}  // namespace eha::ident
