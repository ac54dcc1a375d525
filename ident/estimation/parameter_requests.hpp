// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>

#include "ident/estimation/fit_options.hpp"

namespace eha::ident {

/// Name of denominator term i, e.g. "a2"; of its order, e.g. "n2".
[[nodiscard]] std::string coefficient_name(std::size_t index);
[[nodiscard]] std::string order_name(std::size_t index);

/// Name of numerator coefficient j: "K" when there is only one, else "b0", "b1", ...
[[nodiscard]] std::string numerator_name(std::size_t index, std::size_t terms);

/// How many terms the denominator and the numerator of a structure have.
[[nodiscard]] std::size_t denominator_terms(const StructureOptions& structure);
[[nodiscard]] std::size_t numerator_terms(const StructureOptions& structure);

/// What the user asked of one parameter; null for nothing.
[[nodiscard]] const ParameterRequest* find_request(const StructureOptions& structure, const std::string& name);

[[nodiscard]] bool is_fixed(const StructureOptions& structure, const std::string& name);

/// A parameter that is constant unless the user says something about it other than its fixed value: whether it is free.
[[nodiscard]] bool is_freed(const StructureOptions& structure, const std::string& name);

/// The start, or fixed value, that the user gave; else `otherwise`.
[[nodiscard]] double requested(const StructureOptions& structure, const std::string& name, double otherwise);

/// @throws ConfigError  a request names no parameter of the structure or holds one without a value; the numbers of
/// poles
///                      and zeros make no sense
void check_requests(const StructureOptions& structure);

}  // namespace eha::ident
