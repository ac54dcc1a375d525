// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ident/acceptance_limits.hpp"
#include "ident/model/model.hpp"
#include "ident/uncertainty/bode_curve.hpp"

namespace eha::ident {

/// Returns the band that an input excites: between the lowest and the highest frequency at which its Hann-windowed
/// spectrum reaches a tenth of its greatest amplitude, less the width of the window's main lobe at that level, and not
/// below one period of the record.
/// @param input  at least 8 rows spaced step_s [input unit]
/// @returns nothing for a constant input. Cost O(N log N).
[[nodiscard]] std::optional<FrequencyInterval> excited_band(const Eigen::Ref<const Eigen::VectorXd>& input,
                                                            double step_s);

/// Returns the part of an excited band in which a model's gain and phase are accurate: the widest one, on a logarithmic
/// scale, in which their standard errors are at most `limits.usable_gain_error_dB` and `limits.usable_phase_error_deg`.
/// @param known  as fitted
/// Of a single line it is that line.
/// @returns nothing if there is none: no frequency or a single one of several is accurate, the errors are not known, or
/// the record
///          does not determine a parameter of G
[[nodiscard]] std::optional<FrequencyInterval> usable_band(const Model& model, const ParameterCovariance& known,
                                                           const FrequencyInterval& excited,
                                                           const AcceptanceLimits& limits);

/// Returns the part of a band in which a model and a better one agree: the widest one, on a logarithmic scale, in which
/// their gains differ by at most `limits.usable_gain_error_dB` and their phases by `limits.usable_phase_error_deg`.
/// @returns nothing if there is none
[[nodiscard]] std::optional<FrequencyInterval> agreeing_band(const Model& model, const Model& better,
                                                             const FrequencyInterval& band,
                                                             const AcceptanceLimits& limits);

/// Returns the resonance frequency of a model: its highest gain that exceeds the gain on both sides of it, from a
/// hundredth of the band's lower end to a hundred times its upper one. Nothing for a model without a resonance there.
[[nodiscard]] std::optional<double> resonance_Hz(const Model& model, const FrequencyInterval& band);

}  // namespace eha::ident
