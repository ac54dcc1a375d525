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

/// Name of term i of the initial state, "x0", ...; of the past input's window i, the latest being "past_input_0".
[[nodiscard]] std::string state_name(std::size_t index);
[[nodiscard]] std::string past_input_name(std::size_t index);

/// Whether a name is one of those: a quantity that enters the output linearly and has no request of its own.
[[nodiscard]] bool is_free_response(const std::string& name);

/// How many terms the denominator and the numerator of a structure have.
[[nodiscard]] std::size_t denominator_terms(const StructureOptions& structure);
[[nodiscard]] std::size_t numerator_terms(const StructureOptions& structure);

/// Whether the response to what came before t = 0 is that to an unknown past input. Models of integer order have a
/// finite state instead; the others remember all of their input.
[[nodiscard]] bool wants_past_input(const StructureOptions& structure);

/// What the user asked of one parameter; null for nothing.
[[nodiscard]] const ParameterRequest* find_request(const StructureOptions& structure, const std::string& name);

[[nodiscard]] bool is_fixed(const StructureOptions& structure, const std::string& name);

/// A parameter that is constant unless the user says something about it other than its fixed value: whether it is free.
[[nodiscard]] bool is_freed(const StructureOptions& structure, const std::string& name);

/// The start, or fixed value, that the user gave; else `otherwise`.
[[nodiscard]] double requested(const StructureOptions& structure, const std::string& name, double otherwise);

/// @throws ConfigError  a request names no parameter of the structure or holds one without a value; the numbers of
///                      poles and zeros make no sense; zeros beside a past input
void check_requests(const StructureOptions& structure);

}  // namespace eha::ident
