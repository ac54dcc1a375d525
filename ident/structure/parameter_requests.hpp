// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// The user's request for a parameter; null if there is none.
[[nodiscard]] const ParameterRequest* find_request(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether this parameter is estimated: the structure's choice, unless a request holds or frees it.
[[nodiscard]] bool is_estimated(const StructureOptions& asked, const StructureParameter& parameter);

/// The start or held value of the request; otherwise the structure's.
[[nodiscard]] double requested(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether a pole at 0 is part of what is asked: the denominator's constant is held at 0, or its lowest order is held
/// above 0.
[[nodiscard]] bool declares_integrator(const StructureOptions& asked);

/// Whether the response to input before t = 0 is estimated as that to an unknown past input.
[[nodiscard]] bool wants_past_input(const StructureOptions& asked);

/// Whether the valve map's gain ratio enters the output linearly beside the gain: it is estimated, has no bounds, and
/// there is one numerator term.
[[nodiscard]] bool ratio_enters_linearly(const StructureOptions& asked);

/// @throws ConfigError  a request names no parameter that the structure lets go, or holds one without a value; zeros
///                      beside a past input
void check_requests(const StructureOptions& asked);

}  // namespace eha::ident
