// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/change_text.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha::cli {
namespace {

ident::PlantChange moved(const char* name, ident::ParameterRole role) {
  ident::PlantChange change;
  ident::ParameterChange& p = change.parameters.emplace_back();
  p.name = name;
  p.role = role;
  p.before = -0.206;
  p.after = -0.32418;
  p.half_width = 0.0109;
  p.changed = change.changed = true;
  return change;
}

TEST(ChangeSentences, SayWhoseNumberANullIsAndWhereTheValvesOwnIs) {
  ident::Model model;
  model.name = "io_valve";
  const std::string null = change_lines(moved("null", ident::ParameterRole::valve_null), model);
  EXPECT_NE(null.find("(-0.206 to -0.324)"), std::string::npos) << null;
  EXPECT_NE(null.find("null is that of the io_valve fits"), std::string::npos) << null;
  EXPECT_NE(null.find("eha characterise"), std::string::npos) << null;
  const std::string gain = change_lines(moved("K", ident::ParameterRole::numerator_coefficient), model);
  EXPECT_EQ(gain.find("eha characterise"), std::string::npos) << gain;
}

}  // namespace
}  // namespace eha::cli
