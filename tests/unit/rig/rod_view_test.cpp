// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/rod_view.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "hal/sim/normal_noise.hpp"
#include "hal/sim/sim_rig.hpp"

namespace eha {
namespace {

config::RigLimits limits_between(double lowest_in, double highest_in) {
  config::RigLimits limits;
  limits.travel_min_in = lowest_in;
  limits.travel_max_in = highest_in;
  return limits;
}

hal::RigReading reading_at(double displacement_in) {
  hal::RigReading reading;
  reading.displacement_in = displacement_in;
  reading.feedback_V = displacement_in / 0.6;
  reading.feedback_code = 40000;
  reading.digital_inputs = 5;
  return reading;
}

TEST(RodView, IsNullBeforeTheFirstReadingAndSaysWhyTheRigCannotBeRead) {
  const config::RigLimits limits = limits_between(0.0, 6.0);
  RodView view;
  view.begin({});
  EXPECT_TRUE(view.describe(limits).is_null());
  view.fail(hal::RigStatus::timed_out);
  const auto rod = view.describe(limits);
  EXPECT_NE(rod.at("error").get<std::string>().find("timed_out"), std::string::npos);
  EXPECT_FALSE(rod.contains("displacement_in")) << "an old reading must not look like one of now";
}

TEST(RodView, ShowsNoPlaceThatWasReadLongAgo) {
  const config::RigLimits limits = limits_between(0.0, 6.0);
  RodView view;
  view.begin({});
  view.add(reading_at(2.0));
  EXPECT_TRUE(view.describe(limits).contains("displacement_in"));
  const auto rod = view.describe(limits, std::chrono::steady_clock::now() + std::chrono::seconds(10));
  EXPECT_FALSE(rod.contains("displacement_in")) << rod;
  EXPECT_NE(rod.at("error").get<std::string>().find("not read for 10 s"), std::string::npos) << rod;
  view.add(reading_at(2.1));
  EXPECT_TRUE(view.describe(limits).contains("displacement_in"));
}

TEST(RodView, SaysThatThereIsNoReadingWhereTheSensorGivesNoNumber) {
  const config::RigLimits limits = limits_between(0.0, 6.0);
  RodView view;
  view.begin({});
  const hal::RigReading none = reading_at(std::nan(""));
  for (int i = 0; i < 20; ++i) view.add(none);
  for (const auto& rod : {view.describe(limits), view.describe(limits, none, 0.0)}) {
    EXPECT_NE(rod.at("error").get<std::string>().find("no reading"), std::string::npos) << rod;
    EXPECT_FALSE(rod.contains("displacement_in")) << rod;
  }
  view.add(reading_at(2.0));
  const auto rod = view.describe(limits);
  EXPECT_DOUBLE_EQ(rod.at("displacement_in").get<double>(), 2.0);
  EXPECT_TRUE(rod.at("noise_in").is_null()) << rod;
}

TEST(RodView, ShowsTheLastReadingAndOnlyLinesThatTheRigHas) {
  RodView view;
  hal::RigCapabilities rig;
  rig.has_emergency_stop = true;
  view.begin(rig);
  view.add(reading_at(1.0));
  view.add(reading_at(2.0));
  const auto rod = view.describe(limits_between(0.0, 6.0));
  EXPECT_DOUBLE_EQ(rod.at("displacement_in").get<double>(), 2.0);
  EXPECT_EQ(rod.at("feedback_code"), 40000U);
  EXPECT_EQ(rod.at("digital_inputs"), 5U);
  EXPECT_EQ(rod.at("emergency_stop_open"), false);
  EXPECT_TRUE(rod.at("enable_contact_closed").is_null());
  EXPECT_TRUE(rod.at("noise_in").is_null()) << "two readings do not show the noise";
}

TEST(RodView, MeasuresTheSensorsNoiseAlsoWhileTheRodCreeps) {
  constexpr double kNoise_in = 0.001;
  RodView view;
  view.begin({});
  hal::NormalNoise noise(3);
  double sum = 0.0;
  constexpr int kTrials = 100;
  for (int trial = 0; trial < kTrials; ++trial) {
    for (std::size_t i = 0; i < RodView::kKept; ++i) {
      view.add(reading_at(3.0 + 1e-4 * static_cast<double>(i) + kNoise_in * noise()));
    }
    sum += view.describe(limits_between(0.0, 6.0)).at("noise_in").get<double>();
  }
  // The standard deviation of one figure is about 12 %, of their mean 1.2 %; the creep adds 0.25 %.
  EXPECT_NEAR(sum / kTrials, kNoise_in, 0.05 * kNoise_in);
}

TEST(RodView, IsWhereARunHasMovedTheRodBeforeTheNextReading) {
  RodView view;
  view.begin({});
  for (int i = 0; i < 20; ++i) view.add(reading_at(1.0));
  view.moved_to(4.5);
  auto rod = view.describe(limits_between(0.0, 6.0));
  EXPECT_DOUBLE_EQ(rod.at("displacement_in").get<double>(), 4.5);
  for (int i = 0; i < 20; ++i) view.add(reading_at(4.5));
  rod = view.describe(limits_between(0.0, 6.0));
  EXPECT_DOUBLE_EQ(rod.at("noise_in").get<double>(), 0.0) << "the way is no noise";
}

TEST(RodView, WarnsFromEightyPercentOfTheWayToALimit) {
  const config::RigLimits limits = limits_between(0.0, 6.0);
  RodView view;
  view.begin({});
  for (const double place_in : {0.59, 5.41}) {
    view.add(reading_at(place_in));
    EXPECT_EQ(view.describe(limits).at("near_limit"), true) << place_in;
  }
  for (const double place_in : {0.61, 3.0, 5.39}) {
    view.add(reading_at(place_in));
    EXPECT_EQ(view.describe(limits).at("near_limit"), false) << place_in;
  }
  EXPECT_NEAR(travel_share_at_rest(limits, 4.5), 0.5, 1e-12);
}

}  // namespace
}  // namespace eha
