// SPDX-License-Identifier: GPL-3.0-or-later
// What a changed parameter may come from.
#include "daemon/report/change_causes.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha::report {
namespace {

void add(ident::PlantChange& change, const char* name, ident::ParameterRole role, double after, bool changed = true) {
  ident::ParameterChange& p = change.parameters.emplace_back();
  p.name = name;
  p.role = role;
  p.before = 1.0;
  p.after = after;
  p.half_width = 0.001;
  p.changed = changed;
  change.changed = change.changed || changed;
}

TEST(ChangeCauses, NameForEachKindWhatCommonlyChangesIt) {
  ident::PlantChange change;
  add(change, "a2", ident::ParameterRole::denominator_coefficient, 1.6);
  add(change, "K", ident::ParameterRole::numerator_coefficient, 1.3);
  add(change, "dead_band", ident::ParameterRole::dead_band, 1.2, false);
  add(change, "a1", ident::ParameterRole::denominator_coefficient, 1.1);
  const std::string text = causes_of({&change});
  EXPECT_NE(text.find("K: commonly the supply pressure, dry friction, the load or the sensor"), std::string::npos)
      << text;
  EXPECT_NE(text.find("a2, a1: commonly the load, as another moving mass"), std::string::npos) << text;
  EXPECT_EQ(text.find("dead_band"), std::string::npos) << text;
  EXPECT_TRUE(text.ends_with("The record shows which parameter changed, not why.")) << text;
  EXPECT_FALSE(changes_valve(change));
  change.parameters[2].changed = true;
  EXPECT_NE(causes_of({&change}).find("dead_band: commonly the valve"), std::string::npos);
  EXPECT_TRUE(changes_valve(change));
}

TEST(ChangeCauses, BeginWithWhatTheRecordsShow) {
  ident::PlantChange change;
  add(change, "null", ident::ParameterRole::valve_null, 1.2);
  EXPECT_TRUE(causes_of({&change}, MapCause::leak).starts_with("null: a leak past the piston, as said above"))
      << causes_of({&change}, MapCause::leak);
  EXPECT_TRUE(causes_of({&change}, MapCause::leak_and_valve).starts_with("null: the valve (wear, dirt, "));
  EXPECT_TRUE(causes_of({&change}, MapCause::friction).starts_with("null: dry friction, as said above"));
}

TEST(ChangeCauses, NameTheSensorsScaleWhereTheGainsAloneChangedByOneFactor) {
  ident::PlantChange change;
  add(change, "b1", ident::ParameterRole::numerator_coefficient, 1.2);
  add(change, "b0", ident::ParameterRole::numerator_coefficient, 1.2);
  add(change, "negative_gain_ratio", ident::ParameterRole::negative_gain_ratio, 1.0, false);
  add(change, "a2", ident::ParameterRole::denominator_coefficient, 1.0, false);
  const std::string text = causes_of({&change});
  EXPECT_NE(text.find("another scale of the sensor"), std::string::npos) << text;
  EXPECT_NE(text.find("another supply pressure"), std::string::npos) << text;
  change.parameters[1].after = 1.3;
  EXPECT_EQ(causes_of({&change}).find("another scale"), std::string::npos) << "two factors";
  change.parameters[1].after = 1.2;
  change.parameters[3].changed = true;
  EXPECT_EQ(causes_of({&change}).find("another scale"), std::string::npos) << "a time constant, too";
}

TEST(ChangeCauses, AskForTheUnitsWhereTheFactorIsThatOfTwo) {
  ident::PlantChange change;
  add(change, "K", ident::ParameterRole::numerator_coefficient, 25.4);
  EXPECT_TRUE(causes_of({&change}).starts_with("Check the units")) << causes_of({&change});
}

TEST(ChangeCauses, SayNothingWhereNothingChanged) {
  ident::PlantChange change;
  add(change, "K", ident::ParameterRole::numerator_coefficient, 1.0, false);
  EXPECT_EQ(causes_of({&change}), "");
}

}  // namespace
}  // namespace eha::report
