// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/silent_record.hpp"

#include <gtest/gtest.h>

#include <string>

#include "tests/unit/identify/twin_source.hpp"

namespace eha::identify {
namespace {

std::string said(const ident::Model& model, const Source& source) {
  const ScoredModel scored = score_model(model, source, source.experiment->fit);
  return why_silent(model, source.record, scored, 25.4, " mm");
}

TEST(SilentRecord, IsToldFromAnotherPlant) {
  const Source here = test::source_of(test::seeded(1));
  const ident::Model model = compare_runs({here, here}).runs[0].fit.model;
  EXPECT_EQ(said(model, test::source_of(test::seeded(2))), "");
  hal::SimOptions other = test::seeded(2);
  other.supply_pressure_bar = 60.0;
  EXPECT_EQ(said(model, test::source_of(other)), "") << "another plant is no silent record";

  Source asks_nothing = here;
  asks_nothing.record.input = 0.01 * here.record.input.array() - 0.2;
  EXPECT_NE(said(model, asks_nothing).find("within the dead band of the model"), std::string::npos)
      << said(model, asks_nothing);
  ident::Model without_map = model;
  without_map.input_map.reset();
  EXPECT_NE(said(without_map, asks_nothing).find("and that which estimated the model from"), std::string::npos)
      << said(without_map, asks_nothing);

  Source stands = here;
  stands.record.output = (0.001 * here.record.output).array() + 3.0;
  EXPECT_NE(said(model, stands).find("The output stands ("), std::string::npos) << said(model, stands);
  EXPECT_NE(said(model, stands).find(" mm rms) where the model moves by "), std::string::npos);

  Source turned = here;
  turned.record.output *= -1.0;
  EXPECT_NE(said(model, turned).find("moves the other way"), std::string::npos) << said(model, turned);
}

}  // namespace
}  // namespace eha::identify
