// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"

namespace eha::ident {

/// The structure without the term that a free order belongs to: without that term of the denominator or of several
/// numerator terms; with one numerator term its order held at 0. Requests for what remains are kept. Nothing where no
/// term is left to leave out.
[[nodiscard]] std::optional<StructureOptions> without_order(const StructureOptions& asked, const ParameterKey& order);

/// Fits the structure again without the term of each free order and stores the rise of AR-BIC. All orders of the
/// denominator get the least rise, because a smaller model may keep either of two terms.
/// @param result  of the structure `asked` on the same record and options; has no effect without its criteria
/// Cost: one fit without intervals a free order.
void note_left_out(FitResult& result, const PreparedRecord& prepared, const StructureOptions& asked,
                   const FitOptions& options, const Executor& executor);

}  // namespace eha::ident
