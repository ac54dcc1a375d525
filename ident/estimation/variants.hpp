// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <vector>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/structure/structure_options.hpp"

namespace eha::ident {

/// One way to treat the history before t = 0.
struct Variant {
  LinearPart linear;
  bool bias_coordinate = false;
};

/// At rest before t = 0 but for a constant input bias.
[[nodiscard]] Variant variant_at_rest(const StructureOptions& asked);

/// The ways to try for a record. Several for an unknown past input, each with windows of another size, of which BIC
/// picks one; at rest and with an initial state where the data may decide.
/// @param windows         of the past in the record, when the structure wants a past input
/// @param at_rest_before  whether the record is known to begin at rest
[[nodiscard]] std::vector<Variant> variants(const StructureOptions& asked, std::size_t windows, bool at_rest_before);

/// Whether both treat the history before t = 0 alike.
[[nodiscard]] bool treats_the_past_as(const LinearPart& a, const LinearPart& b);

/// Parameters that are estimated.
[[nodiscard]] std::size_t free_parameters(const Parametrisation& parametrisation, const LinearPart& linear);

}  // namespace eha::ident
