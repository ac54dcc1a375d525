// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/rod_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "daemon/eha/rehearsal_text.hpp"

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

Json rod_at(double displacement_in) {
  return {{"displacement_in", displacement_in},
          {"feedback_V", displacement_in / 0.6},
          {"feedback_code", 48000},
          {"at_rail", false},
          {"noise_in", 0.0006},
          {"digital_inputs", 3},
          {"emergency_stop_open", nullptr},
          {"enable_contact_closed", true},
          {"travel_min_in", 0.0},
          {"travel_max_in", 6.0},
          {"travel_percent", 90.0},
          {"near_limit", displacement_in > 5.4},
          {"error", nullptr}};
}

TEST(TravelBar, MarksTheRodAndTheLastFifthTowardsEachLimit) {
  EXPECT_EQ(travel_bar(3.0, 0.0, 6.0), "0.000 [====----------------#----------------====] 6.000");
  EXPECT_EQ(travel_bar(0.0, 0.0, 6.0), "0.000 [#===---------------------------------====] 6.000");
  EXPECT_EQ(travel_bar(9.0, 0.0, 6.0), "0.000 [====---------------------------------===#] 6.000");
}

TEST(TravelBar, MarksNoRodThatHasNoPlace) {
  EXPECT_EQ(travel_bar(std::nan(""), 0.0, 6.0), "0.000 [====---------------------------------====] 6.000");
}

TEST(RodText, ShowsPlaceSensorAndLines) {
  const std::string text = aligned(rod_lines(rod_at(3.0), DisplayUnit()));
  EXPECT_NE(text.find("rod      3.000 in  0.000 ["), std::string::npos) << text;
  EXPECT_NE(text.find("sensor   +5.0000 V, code 48000, noise 0.0006 in RMS"), std::string::npos) << text;
  EXPECT_NE(text.find("lines    inputs 0x00000003, emergency stop none, enable contact closed"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("WARNING"), std::string::npos);
  EXPECT_NE(aligned(rod_lines(rod_at(3.0), DisplayUnit("mm"))).find("76.200 mm  0.000 ["), std::string::npos);
}

TEST(RodText, WarnsNearALimitAndNamesIt) {
  EXPECT_NE(aligned(rod_lines(rod_at(5.7), DisplayUnit())).find("WARNING  90 % of the way to the upper travel limit"),
            std::string::npos);
}

TEST(RodText, NamesTheWayBackBeyondALimitAndTheMiddleNearOne) {
  const DisplayUnit mm("mm");
  EXPECT_EQ(way_to_middle(rod_at(3.0), mm), "");
  EXPECT_EQ(way_to_middle(nullptr, mm), "") << "a place that is not known";
  EXPECT_EQ(way_to_middle({{"error", "the rig cannot be read"}}, mm), "");
  EXPECT_EQ(way_to_middle(rod_at(5.7), mm), "eha goto 76.2mm");
  EXPECT_EQ(way_to_middle(rod_at(6.1), mm), "eha goto 76.2mm");
  EXPECT_EQ(way_to_middle(rod_at(-0.1), DisplayUnit()), "eha goto 3in");
  EXPECT_EQ(beyond_limit(3.0, {0.0, 6.0}, mm), "");
  const std::string text = aligned(rod_lines(rod_at(6.1), mm));
  EXPECT_NE(text.find("WARNING  2.540 mm beyond the upper travel limit of 152.400 mm: look at the rod"),
            std::string::npos)
      << text;
  EXPECT_NE(beyond_limit(-0.1, {0.0, 6.0}, DisplayUnit()).find("0.100 in beyond the lower"), std::string::npos);
}

TEST(RodText, SaysWhyNothingIsKnown) {
  EXPECT_EQ(aligned(rod_lines(nullptr, DisplayUnit())), "rod      not read yet\n");
  EXPECT_EQ(aligned(rod_lines({{"error", "the rig cannot be read"}}, DisplayUnit())),
            "rod      the rig cannot be read\n");
}

TEST(DriftText, HasNoSignWithoutAFigure) {
  EXPECT_EQ(drift_text(-0.00001, "in"), "does not drift");
  EXPECT_EQ(drift_text(0.0, "in"), "does not drift");
  EXPECT_EQ(drift_text(-0.0123, "in"), "drifts -0.0123 in/s");
}

}  // namespace
}  // namespace eha::cli
