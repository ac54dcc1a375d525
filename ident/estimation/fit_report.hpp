// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/estimation/fit.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

struct Normalised {
  TransferFunction g;
  double divisor;
};

/// Orders rising, the coefficient of the second lowest one 1.
[[nodiscard]] Normalised normalised(TransferFunction g);

/// The linear quantities as a model file names them, and `solution` in their terms. A free response that starts with
/// the step response of 1/D holds the offset and the state: sum c_i s^i/D with c_i = x_i + initial_output a_i.
[[nodiscard]] LinearPart as_reported(const Outcome& outcome, const TransferFunction& g, LinearSolution& solution);

/// Simulates result.model over the compared rows and scores it: the estimating ones into `estimation`, the rest into
/// `validation`.
void fill_validation(FitResult& result, const Record& record, const Comparison& comparison);

/// What profiles of the cost need beside the optimum.
struct ProfileSearch {
  Parametrisation::Scale scale;
  double largest_input;  ///< max |u|
  const Executor& executor;
};

/// Parameters as the model file lists them, with the uncertainty of the free ones.
/// @param profile  none: intervals from standard errors alone
void fill_parameters(FitResult& result, const ComparedRecord& compared, const Outcome& outcome,
                     const LinearPart& linear, const LinearSolution& solution, const StructureOptions& structure,
                     const ProfileSearch* profile);

}  // namespace eha::ident
