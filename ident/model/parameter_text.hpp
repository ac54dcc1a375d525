// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What every figure of a dead band is.
inline constexpr std::string_view kTimeConstantIs = "a2: the time constant T";  ///< of integrator_lag
inline constexpr std::string_view kDeadBandIs = "dead_band: half the dead band, from the null to an edge";

inline constexpr double kInterval95 = 1.96;  ///< half width of a 95 % interval [standard errors]

/// " in", what follows a number; empty without a unit, as of a record that has none.
[[nodiscard]] inline std::string after_number(const std::string& unit) { return unit.empty() ? "" : " " + unit; }

/// An error of the output for people, with the same three digits everywhere: "0.00253", "0.00253 in".
[[nodiscard]] std::string error_figure(double error);
[[nodiscard]] inline std::string error_text(double error, const std::string& unit) {
  return error_figure(error) + after_number(unit);
}

/// A factor or an angle for people: two digits, and from 100 on a whole number; an exponent from 1e5 on. "1.4", "120".
[[nodiscard]] std::string figure_text(double figure);

/// R2 or a fit [%] with two decimals; "above 99.99" where they would round to 100.00, which nothing measured reaches.
[[nodiscard]] std::string percent_text(double percent, int decimals = 2);

/// Covariance of two estimated parameters; 0 where one is fixed or the correlation is not known.
[[nodiscard]] double covariance(const Model& model, const ParameterEstimate& a, const ParameterEstimate& b);

/// Returns half the width of the 95 % interval: 0 if fixed, not finite if the interval is unbounded.
[[nodiscard]] double half_width95(const ParameterEstimate& parameter);

/// Formats a value with half the width of its 95 % interval: "0.1305 +- 0.0008". Both have the digits that the half
/// width justifies; "+-" means this in all texts. A value that is fixed or has no standard error stands alone.
/// @param sign  between them
[[nodiscard]] std::string with_interval(const ParameterEstimate& parameter, std::string_view sign = "+-");

/// Formats a value with the decimals that two digits of its half width have: "-0.324" for -0.32418 +- 0.011. A value
/// without one (0, not finite) has four digits.
[[nodiscard]] std::string rounded_to(double value, double half_width);

/// Formats any value in the same way. @param half_width  more than 0
[[nodiscard]] std::string with_half_width(double value, double half_width, std::string_view sign = "+-");

}  // namespace eha::ident
