// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "daemon/identify/identification.hpp"

namespace eha::identify::test {

enum class Came { accepted, rejected, unconverged };

/// A model as a fit would leave it: 0.5 / (2 s^1.75 + 1).
inline IdentifiedModel model_that(Came came, const std::string& name = "fo") {
  IdentifiedModel identified;
  identified.structure.name = name;
  identified.structure.structure = ident::structures::fo();
  ident::Model& model = identified.result.model;
  model.name = name;
  model.transfer_function = {.numerator = {{0.5, 0.0}}, .denominator = {{2.0, 1.75}, {1.0, 0.0}}, .delay_s = 0.0};
  model.parameters = {{.name = "n2",
                       .value = 1.7512,
                       .std = 0.0107,
                       .lower95 = 1.73,
                       .upper95 = 1.77,
                       .fixed = false,
                       .role = ident::ParameterRole::denominator_order},
                      {.name = "n0",
                       .value = 0.0,
                       .std = 0.0,
                       .lower95 = 0.0,
                       .upper95 = 0.0,
                       .fixed = true,
                       .role = ident::ParameterRole::denominator_order}};
  model.estimation.emplace();
  model.estimation->converged = came != Came::unconverged;
  model.estimation->score.r2_percent = 99.5;
  model.validation.emplace();
  model.validation->score.r2_percent = 98.25;
  model.validation->offset_reestimated.emplace().r2_percent = 98.75;
  model.stability.emplace().stable = true;
  model.verdict = ident::Verdict{came == Came::accepted, {"A sentence about it."}};
  return identified;
}

}  // namespace eha::identify::test
