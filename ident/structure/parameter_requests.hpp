// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// Returns the user's request for a parameter; null if there is none.
[[nodiscard]] const ParameterRequest* find_request(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether this parameter is estimated: the structure's choice, unless a request holds or frees it.
[[nodiscard]] bool is_estimated(const StructureOptions& asked, const StructureParameter& parameter);

/// Returns the start or held value of the request; without one that of the structure.
[[nodiscard]] double requested(const StructureOptions& asked, const StructureParameter& parameter);

/// Whether the requested model has a pole at 0: the denominator's constant is held at 0, or its lowest order is held
/// above 0.
[[nodiscard]] bool declares_integrator(const StructureOptions& asked);

/// Whether the response to input before t = 0 is estimated through an unknown past input.
[[nodiscard]] bool wants_past_input(const StructureOptions& asked);

/// Whether the valve map's gain ratio enters the output linearly with the gain: it is estimated and unbounded, and
/// there is one numerator term.
[[nodiscard]] bool ratio_enters_linearly(const StructureOptions& asked);

/// @throws ConfigError  a request names no parameter that the structure exposes, or holds one without a value; zeros
///                      with a past input
void check_requests(const StructureOptions& asked);

}  // namespace eha::ident
