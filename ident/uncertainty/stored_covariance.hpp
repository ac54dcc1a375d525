// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/uncertainty/bode_curve.hpp"

namespace eha::ident {

/// The covariance that a model file holds: standard errors and correlation. Parameters that the record could not tell
/// apart are left out; empty for a model without an estimation.
[[nodiscard]] ParameterCovariance stored_covariance(const Model& model);

}  // namespace eha::ident
