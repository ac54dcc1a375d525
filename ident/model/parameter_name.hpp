// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "ident/model/model.hpp"

namespace eha::ident {

/// What a person reads for a parameter: "half dead band" for dead_band, as every figure of it is a half, and "negative
/// gain ratio". Others have the name that they have in files.
[[nodiscard]] inline std::string shown_name(ParameterRole role, const std::string& name) {
  if (role == ParameterRole::dead_band) return "half dead band";
  return role == ParameterRole::negative_gain_ratio ? "negative gain ratio" : name;
}

}  // namespace eha::ident
