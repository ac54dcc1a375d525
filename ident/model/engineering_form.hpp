// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// Writes a model of whole orders in engineering terms: gain K of the lowest power of s, a time constant T [s] for each
/// real pole and TD for each real zero, natural frequency f0 [Hz] and damping D for each pair, dead time.
///   "K = 0.1479 in/(V s), integrating; T = 0.0056 s; f0 = 12.1 Hz, D = 0.31; dead time 6.3 ms"
/// A root in the right half plane has a negative T or D.
/// Where the model has a parameter K of another size, because its denominator does not end in 1, the gain is K/a0.
/// A grey box comes first, with its values: "friction: gain 0.181 m/(V s), lag_s 0.465 s, friction 0.616 V; its linear
/// form: K = ...".
/// @param plus_minus  before half the 95 % interval of K, T and dead time where it is known; empty: without it, each
/// figure rounded as with it
/// @returns empty for a model with a fractional order, or without a gain
[[nodiscard]] std::string engineering_form(const Model& model, std::string_view plus_minus = {});

/// Unit of a parameter of a model: "in/(V s)", "s^0.75", "V", "s"; empty for a ratio or an order.
[[nodiscard]] std::string unit_of(const ParameterEstimate& parameter, const Model& model);

/// Whether the model's dead time has, within its usable band, the phase of an equal lag and attenuates as little: the
/// record does not tell them apart. False without a usable band.
[[nodiscard]] bool may_be_lag(const Model& model);

}  // namespace eha::ident
