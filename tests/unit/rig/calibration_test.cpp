// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/calibration.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "config/measured_check.hpp"
#include "core/error.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha {
namespace {

const std::string kRigs = EHA_SOURCE_DIR "/config/rigs/";

std::string refusal(const std::vector<CalibrationPoint>& points) {
  try {
    static_cast<void>(calibrated(points));
  } catch (const DataError& error) {
    return error.what();
  }
  return "";
}

TEST(Calibration, FindsAnExactLine) {
  const Calibration found = calibrated(std::vector<CalibrationPoint>{{0.5, -8.0}, {2.95, 0.0}, {5.4, 8.0}});
  EXPECT_NEAR(found.scale_in_per_V, 0.30625, 1e-12);
  EXPECT_NEAR(found.offset_in, 2.95, 1e-12);
  EXPECT_NEAR(found.residual_std, 0.0, 1e-12);
  ASSERT_EQ(found.residuals_in.size(), 3U);
}

TEST(Calibration, NamesTheReadingThatMakesTheScaleUncertain) {
  std::vector<CalibrationPoint> points{{0.5, -8.0}, {2.95, 0.0}, {5.4, 8.0}};
  EXPECT_EQ(doubt_about(points, calibrated(points)), "");
  points[1].position_in += 0.06;
  const std::string of_three = doubt_about(points, calibrated(points));
  EXPECT_NE(of_three.find("the scale is known to +- 18 % only"), std::string::npos) << of_three;
  EXPECT_NE(of_three.find("the one at 3.01 in: measure it again"), std::string::npos) << of_three;
  EXPECT_NE(of_three.find("a fourth one shows which"), std::string::npos) << of_three;
  // An end has the smaller residual, and yet is the wrong one.
  points = {{0.7, -8.0}, {1.73, -4.0}, {2.95, 0.0}, {4.18, 4.0}, {5.4, 8.0}};
  const std::string of_five = doubt_about(points, calibrated(points), DisplayUnit("mm"));
  EXPECT_NE(of_five.find("the one at 17.78 mm"), std::string::npos) << of_five;
}

TEST(Calibration, NamesTheOnePointWithoutWhichTheOthersLieOnALine) {
  std::vector<CalibrationPoint> points;
  for (const auto& [mm, volts] : {std::pair{10.2, 0.656}, {40.1, 2.625}, {75.3, 4.921}, {110.0, 7.5}, {139.8, 9.186}}) {
    points.push_back({mm / 25.4, volts});
  }
  const auto lone = lone_point(points, 0.02);
  ASSERT_TRUE(lone);
  EXPECT_EQ(lone->index, 3U);
  EXPECT_NEAR(lone->off_in * 25.4, -4.1, 0.2);
  EXPECT_LT(lone->others_in, 0.02);
  EXPECT_FALSE(lone_point(points, 1.0)) << "all are within the tolerance, whichever is left out";
  points[1].position_in += 0.2;
  EXPECT_FALSE(lone_point(points, 0.02)) << "two are off";
  points.resize(4);
  EXPECT_FALSE(lone_point(points, 0.02)) << "three of four lie on a line by chance";
}

TEST(Calibration, AsksForThreePlacesThatDiffer) {
  EXPECT_NE(refusal({{0.5, -8.0}, {2.95, 0.0}, {2.95, 0.001}}).find("2 places that differ"), std::string::npos);
}

TEST(Calibration, HasStandardErrorsThatHoldOverManyRulers) {
  ident::PortableDraw draw(3);
  constexpr int kRulers = 2000;
  double scale_squares = 0.0;
  double offset_squares = 0.0;
  double scale_variance = 0.0;
  double offset_variance = 0.0;
  for (int i = 0; i < kRulers; ++i) {
    std::vector<CalibrationPoint> points;
    for (int k = 0; k < 8; ++k) points.push_back({0.3 + 0.6 * (1.0 + k) + 0.01 * draw.normal(), 1.0 + k});
    const Calibration found = calibrated(points);
    scale_squares += std::pow(found.scale_in_per_V - 0.6, 2) / kRulers;
    offset_squares += std::pow(found.offset_in - 0.3, 2) / kRulers;
    scale_variance += found.scale_std * found.scale_std / kRulers;
    offset_variance += found.offset_std * found.offset_std / kRulers;
  }
  EXPECT_NEAR(scale_variance / scale_squares, 1.0, 0.15);
  EXPECT_NEAR(offset_variance / offset_squares, 1.0, 0.15);
}

TEST(Calibration, RefusesTooFewPointsAndPointsOnNoLine) {
  EXPECT_NE(refusal({{1.0, 1.0}, {2.0, 2.0}}).find("2 positions, at least 3"), std::string::npos);
  EXPECT_NE(refusal({{1.0, 3.0}, {2.0, 3.0}, {3.0, 3.0}}).find("spread over 0 V"), std::string::npos);
  EXPECT_NE(refusal({{1.0, 1.0}, {3.0, 2.0}, {1.2, 3.0}, {2.9, 4.0}}).find("lie on no line"), std::string::npos);
  EXPECT_NE(refusal({{1.0, 1.0}, {2.0, NAN}, {3.0, 3.0}}).find("finite"), std::string::npos);
}

TEST(CalibratedRigText, ChangesThreeValuesAndNothingElse) {
  const config::RigConfig rig = config::load_rig(kRigs + "pci1716.toml");
  const std::string text = calibrated_rig_text(rig, {.scale_in_per_V = 0.2961, .offset_in = 2.9512}, "2026-05-04");
  const config::RigConfig changed = config::parse_rig(text, "new.toml");
  const hal::Conversion conversion = hal::conversion_of(changed.backend);
  EXPECT_EQ(conversion.scale_in_per_V, 0.2961);
  EXPECT_EQ(conversion.offset_in, 2.9512);
  EXPECT_EQ(conversion.calibration_date, "2026-05-04");
  EXPECT_NE(text.find("scale_in_per_V = 0.2961          # displacement sensor"), std::string::npos) << "comments stay";
  EXPECT_NE(text.find("calibration_date = \"2026-05-04\" # of scale and offset"), std::string::npos);
  const auto lines = [](const std::string& of) { return std::count(of.begin(), of.end(), '\n'); };
  EXPECT_EQ(lines(text), lines(rig.text));
}

TEST(CalibratedRigText, AddsKeysThatTheFileLeavesOut) {
  const std::string before =
      "schema = 1\nname = \"r\"\nbackend = \"sim\"\n[limits]\ncommand_min_V = -5.0\ncommand_max_V = 5.0\n"
      "slew_V_per_s = 20.0\nsafe_V = 0.0\ntravel_min_in = 0.15\ntravel_max_in = 5.7\n"
      "stopping_deceleration_in_per_s2 = 200.0\nvelocity_limit_in_per_s = 8.0\nfrozen_sensor_s = 0.5\n"
      "[sim] # \xC3\xBC\nscale_in_per_V = 0.6 # \xC3\xA9\nseed = 3\n";
  const std::string text = calibrated_rig_text(config::parse_rig(before, "r.toml"),
                                               {.scale_in_per_V = 0.61, .offset_in = -0.02}, "2026-05-04");
  EXPECT_NE(text.find("[sim] # \xC3\xBC\noffset_in = -0.02\nscale_in_per_V = 0.61 # \xC3\xA9\nseed = 3\n"),
            std::string::npos)
      << text;
}

TEST(CalibratedRigText, WritesMillimetresWhereTheUnitsOfTheFileAreMillimetres) {
  const config::RigConfig inches = config::load_rig(kRigs + "sim.toml");
  const config::RigConfig rig = config::parse_rig("units = \"mm\"\n" + inches.text, "r.toml");
  const std::string text = calibrated_rig_text(rig, {.scale_in_per_V = 0.61, .offset_in = -0.02}, "2026-05-04");
  EXPECT_NE(text.find("\nscale_mm_per_V = 15.494 "), std::string::npos) << text;
  EXPECT_NE(text.find("volts [mm/V]\noffset_mm = -0.508 "), std::string::npos) << text;
  EXPECT_EQ(text.find("scale_in_per_V"), std::string::npos) << text;
  const hal::Conversion conversion = hal::conversion_of(config::parse_rig(text, "new.toml").backend);
  EXPECT_NEAR(conversion.scale_in_per_V, 0.61, 1e-6);
  EXPECT_NEAR(conversion.offset_in, -0.02, 1e-6);
  const std::string followed = rig_text_with(rig, *rig.limits.following);
  EXPECT_NE(followed.find("\ngain_positive_mm_per_V_s = 1.8796 # half the gain extending: speed over volts outside the "
                          "dead band [mm/(V s)]\n"),
            std::string::npos)
      << followed;
  EXPECT_NE(followed.find("\nlimit_in = 0.1 "), std::string::npos) << "what was not measured stays";
  EXPECT_EQ(calibrated_rig_text(inches, {.scale_in_per_V = 0.61}, "2026-05-04").find("_mm_per_V"), std::string::npos);
}

TEST(RigTextWithoutFollowing, HasAllElse) {
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  const config::RigConfig bare = config::parse_rig(rig_text_without_following(rig), "r.toml");
  EXPECT_FALSE(bare.limits.following);
  EXPECT_NE(bare.text.find("\n# null_V = -0.2 "), std::string::npos) << bare.text;
  EXPECT_DOUBLE_EQ(bare.limits.travel_max_in, rig.limits.travel_max_in);
  EXPECT_DOUBLE_EQ(bare.realtime.sample_period_s, rig.realtime.sample_period_s);
  EXPECT_EQ(rig_text_without_following(bare), bare.text) << "there is nothing to comment out";
}

TEST(RigTextWith, HasASumThatFitsWhatWasMeasured) {
  config::Following following{.gain_positive_in_per_V_s = 0.0612345,
                              .gain_negative_in_per_V_s = 0.0498765,
                              .null_V = -0.2123456,
                              .dead_band_V = 0.2123456,
                              .null_uncertainty_V = 0.0061234,
                              .dead_band_uncertainty_V = 0.0071234,
                              .gain_uncertainty_percent = 1.2345678,
                              .measured_check = 7};
  for (const char* units : {"", "units = \"mm\"\n"}) {
    const config::RigConfig rig = config::parse_rig(units + config::load_rig(kRigs + "sim.toml").text, "r.toml");
    following.measured_rig_check = config::measured_rig_check_of(rig.backend);
    const std::string text = rig_text_with(rig, following);
    const config::RigConfig changed = config::parse_rig(text, "r.toml");
    EXPECT_TRUE(config::is_as_measured(changed)) << text;
    EXPECT_EQ(rig_text_with(changed, *changed.limits.following), text);
  }
  following.dead_band_uncertainty_V.reset();
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  EXPECT_EQ(rig_text_with(rig, following).find("measured_check"), std::string::npos) << "nothing says it is measured";
}

/// A calibration with a scale so many times that of a rig.
Calibration scaled_by(double factor, const config::RigConfig& rig) {
  const hal::Conversion conversion = hal::conversion_of(rig.backend);
  return {.scale_in_per_V = factor * conversion.scale_in_per_V, .offset_in = conversion.offset_in};
}

/// The sample rig with its [following] signed as measured.
config::RigConfig measured_rig() {
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  config::Following following = *rig.limits.following;
  following.dead_band_uncertainty_V = 0.01;
  following.measured_rig_check = config::measured_rig_check_of(rig.backend);
  return config::parse_rig(rig_text_with(rig, following), "r.toml");
}

TEST(CalibratedRigText, TakesTheMeasuredGainsAlong) {
  const config::RigConfig measured = measured_rig();
  const config::Following& before = *measured.limits.following;
  const config::RigConfig changed =
      config::parse_rig(calibrated_rig_text(measured, scaled_by(1.4, measured), "2026-05-04"), "r.toml");
  EXPECT_TRUE(config::is_as_measured(changed)) << changed.text;
  EXPECT_NEAR(changed.limits.following->gain_positive_in_per_V_s, 1.4 * before.gain_positive_in_per_V_s, 1e-5);
  EXPECT_NEAR(changed.limits.following->gain_negative_in_per_V_s, 1.4 * before.gain_negative_in_per_V_s, 1e-5);
  EXPECT_EQ(changed.limits.following->null_V, before.null_V);
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  const config::RigConfig by_hand =
      config::parse_rig(calibrated_rig_text(rig, scaled_by(1.4, rig), "2026-05-04"), "r.toml");
  EXPECT_EQ(by_hand.limits.following->gain_positive_in_per_V_s, rig.limits.following->gain_positive_in_per_V_s);
}

TEST(CalibratedRigText, DoesNotSignGainsOfAnotherSensorAsMeasured) {
  const config::RigConfig measured = measured_rig();
  for (const double factor : {1.6, 2.0}) {
    const config::RigConfig changed =
        config::parse_rig(calibrated_rig_text(measured, scaled_by(factor, measured), "2026-05-04"), "r.toml");
    EXPECT_FALSE(config::is_as_measured(changed)) << changed.text;
    EXPECT_NEAR(changed.limits.following->gain_positive_in_per_V_s,
                factor * measured.limits.following->gain_positive_in_per_V_s, 1e-5);
  }
}

TEST(CalibrationShift, NamesARulerReadFromAnotherZero) {
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  Calibration found = scaled_by(1.0, rig);
  EXPECT_EQ(shift_text(rig, found, DisplayUnit("in")), "");
  found.offset_in += 0.05;
  EXPECT_EQ(shift_text(rig, found, DisplayUnit("in")), "");
  found.offset_in += 0.95;
  const std::string text = shift_text(rig, found, DisplayUnit("in"));
  EXPECT_NE(text.find("the rod stands at 1.15 in where "), std::string::npos) << text;
  EXPECT_NE(shift_text(rig, scaled_by(0.75, rig), DisplayUnit("in")), "");
}

TEST(CalibratedRigText, RefusesACalibrationThatTheLimitsContradict) {
  const config::RigConfig rig = config::load_rig(kRigs + "sim.toml");
  EXPECT_THROW(static_cast<void>(calibrated_rig_text(rig, {.scale_in_per_V = 0.1, .offset_in = 0.0}, "2026-05-04")),
               ConfigError);
}

}  // namespace
}  // namespace eha
