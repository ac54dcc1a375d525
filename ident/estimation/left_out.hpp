// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// The structure without the term that a free order belongs to: without that term of the denominator or of several
/// numerator terms; with one numerator term its order held at 0. Requests for what remains are kept. Nothing where no
/// term is left to leave out.
[[nodiscard]] std::optional<StructureOptions> without_order(const StructureOptions& asked, const ParameterKey& order);

/// The structure in which a coefficient is 0: a pole at 0 for the denominator's lowest, a degree less for its highest,
/// a zero less for one of several of the numerator. Requests for what remains are kept. Nothing for another coefficient
/// of the denominator, without which no model is stable, for one that is not estimated, where G would not be proper or
/// have a common factor s, and for a base order.
[[nodiscard]] std::optional<StructureOptions> without_coefficient(const StructureOptions& asked,
                                                                  const ParameterKey& coefficient);

/// A structure that has been fitted to the same record with the same options.
struct FittedStructure {
  std::string signature;  ///< of its structure, see signature()
  double ar_bic;
};

/// Stores the rise of AR-BIC without the term of each free order. All orders of the denominator get the least rise,
/// because a smaller model may keep either of two terms.
/// @param result   of the structure `asked` on the same record and options; has no effect without its criteria
/// @param fitted   what need not be fitted again
/// Cost: one fit without intervals for each smaller structure that is not among `fitted`.
void note_left_out(FitResult& result, const PreparedRecord& prepared, const StructureOptions& asked,
                   const FitOptions& options, const Executor& executor, std::vector<FittedStructure> fitted = {});

}  // namespace eha::ident
