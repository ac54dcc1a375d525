// SPDX-License-Identifier: GPL-3.0-or-later
// A grey box is advised only where its fit to the record holds.
#include "daemon/identify/grey_box_trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "daemon/identify/judging.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"
#include "tests/unit/identify/made_axis.hpp"

namespace eha::identify {
namespace {

enum class Map { none, valve };

/// The integrator with a lag, fitted alone. Its residual speaks for friction.
Identification fitted(const Source& source, Map map) {
  IdentificationTask task = task_of(source);
  ident::StructureOptions structure;
  structure.name = "integrator_lag";
  structure.structure = ident::structures::integrator_lag();
  if (map == Map::valve) structure.structure = ident::structures::behind_valve(structure.structure);
  task.structures.push_back(structure);
  return identify(source, task, {}, {});
}

bool advises_friction(const ident::Model& model) {
  const std::vector<std::string>& reasons = model.verdict->reasons;
  return std::any_of(reasons.begin(), reasons.end(),
                     [](const std::string& reason) { return reason.find("--model friction") != std::string::npos; });
}

TEST(GreyBoxTrial, AdvisesFrictionWhereItHolds) {
  for (const int seed : {1, 2}) {
    const Identification found = fitted(test::made_axis({.friction_V = 0.33, .seed = seed}), Map::valve);
    const ident::Model& model = found.models.front().result.model;
    ASSERT_EQ(ident::grey_box_to_try(model, *model.verdict), &ident::friction_kind()) << "seed " << seed;
    EXPECT_TRUE(advises_friction(model)) << "seed " << seed;
    EXPECT_EQ(model.provenance.at(ident::kGreyBoxHolds).find("errs 0."), 0U) << "seed " << seed;
    EXPECT_EQ(found.models.size(), 1U) << "the trial is no model of the answer";
  }
}

TEST(GreyBoxTrial, AdvisesNoFrictionForPlay) {
  int asked = 0;
  for (int seed = 1; seed <= 4; ++seed) {
    const Identification found = fitted(test::made_axis({.play_mm = 0.15, .seed = seed}), Map::none);
    const ident::Model& model = found.models.front().result.model;
    asked += ident::grey_box_to_try(model, *model.verdict) != nullptr ? 1 : 0;
    EXPECT_FALSE(advises_friction(model)) << "seed " << seed;
  }
  EXPECT_GE(asked, 3) << "the residual must look like friction's";
}

}  // namespace
}  // namespace eha::identify
