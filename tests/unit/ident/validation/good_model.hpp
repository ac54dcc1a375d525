// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ident/model/model.hpp"

namespace eha::ident {

/// A model whose reports meet every limit. For tests of verdicts.
inline Model good_model() {
  Model model;
  model.estimation = EstimationReport{{99.0, 0.01, 90.0, -0.1, 0.1, 500}, {}, {}, 20, 0.1, "converged", true};
  ValidationReport validation;
  validation.score = {98.5, 0.01, 88.0, -0.2, 0.15, 500};
  validation.acf = {{0, 1}, {1.0, 0.01}, 0.09, 0.12};
  validation.ccf = {{-1, 0, 1, 2}, {0.9, 0.0, 0.01, 0.02}, 0.09, 0.12};
  validation.ljung_box_p = 0.4;
  validation.tests = ResidualTests{1, {20.0, 21, 0.5}, {19.0, 19, 0.5}};
  validation.extrapolated_percent = 0.0;
  model.validation = validation;
  model.stability = StabilityReport{true, "matignon", 0.5};
  return model;
}

}  // namespace eha::ident
