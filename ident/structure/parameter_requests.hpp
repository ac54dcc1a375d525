// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// What the user asked of one parameter; null for nothing.
[[nodiscard]] const ParameterRequest* find_request(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether the record sets this parameter: the structure's choice, unless a request holds or frees it.
[[nodiscard]] bool is_estimated(const StructureOptions& asked, const StructureParameter& parameter);

/// The start, or held value, that the user gave; else the structure's.
[[nodiscard]] double requested(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether the response to what came before t = 0 is that to an unknown past input.
[[nodiscard]] bool wants_past_input(const StructureOptions& asked);

/// Whether the valve map's gain ratio enters the output linearly beside the gain: it is estimated, has no bounds, and
/// there is one numerator term.
[[nodiscard]] bool ratio_enters_linearly(const StructureOptions& asked);

/// @throws ConfigError  a request names no parameter that the structure lets go, or holds one without a value; zeros
///                      beside a past input
void check_requests(const StructureOptions& asked);

}  // namespace eha::ident
