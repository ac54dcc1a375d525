// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "ident/model/model.hpp"

namespace eha::ident {

inline constexpr double kInterval95 = 1.96;  ///< half width of a 95 % interval [standard errors]

/// Half the width of the 95 % interval; not finite where the interval has no end. 0 when fixed.
[[nodiscard]] double half_width95(const ParameterEstimate& parameter);

/// A value with half the width of its 95 % interval, which "+-" means in all texts, both with the digits that the
/// half width justifies: "0.1305 +- 0.0008". A value that is fixed or has no standard error stands alone.
/// @param sign  between them
[[nodiscard]] std::string with_interval(const ParameterEstimate& parameter, std::string_view sign = "+-");

/// The same of any value. @param half_width  more than 0
[[nodiscard]] std::string with_half_width(double value, double half_width, std::string_view sign = "+-");

}  // namespace eha::ident
