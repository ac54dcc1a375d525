// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/uncertainty/bode_curve.hpp"

namespace eha::ident {

/// Returns the covariance of a model file, from its standard errors and correlation. Leaves out parameters that the
/// record could not distinguish; empty for a model without an estimation.
[[nodiscard]] ParameterCovariance stored_covariance(const Model& model);

}  // namespace eha::ident
