// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// The structures inside the asked one that lack its valve map or one of its freedoms: a parameter that a request or
/// the structure frees in addition is held again (a delay at 0, a base order at 1, orders at whole numbers), or the
/// highest power of s of a polynomial, or the term of the highest free order, is left out. Requests for what remains
/// are kept; sub-structures that they forbid are left out.
[[nodiscard]] std::vector<StructureOptions> sub_structures(const StructureOptions& asked);

/// Text that differs between structures inside one another: their terms and the values that are held.
[[nodiscard]] std::string signature(const StructureOptions& asked);

}  // namespace eha::ident
