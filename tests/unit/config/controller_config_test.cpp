// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/controller_config.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "config/file_kind.hpp"
#include "config/toml_section.hpp"
#include "config/track_text.hpp"
#include "core/error.hpp"

namespace eha::config {
namespace {

ControllerConfig controller() {
  ControllerConfig c;
  c.name = "axis";
  c.purpose = "hold";
  ident::AxisSettings& s = c.settings;
  s.tick_s = 0.002;
  s.kind = ident::FeedbackKind::fopid;
  s.feedback = {.kp = 12.3456789012345,
                .ki = 40.0,
                .kd = 0.1,
                .integral_order = 0.85,
                .derivative_order = 1.1,
                .filter_s = 0.005};
  s.rest_error = 0.0018;
  s.tracking_s = 0.3;
  s.most_speed = 0.6;
  s.inverse = {.null = -0.2, .dead_band = 0.15, .gain_positive = 1.0 / 7.0, .gain_negative = 0.13, .smoothing = 0.02};
  s.feed_forward = {.position_rate = 0.01, .rest = 2.9, .acceleration_s = 0.007};
  s.reference = {.lowest = 0.15, .highest = 5.75, .velocity = 0.4, .acceleration = 1.0, .jerk = 25.0};
  s.command_min = -5.0;
  s.command_max = 5.0;
  s.slew_per_s = 20.0;
  c.promise.twins = 50;
  c.promise.following_rms_in = {0.0004, 0.0001, 0.0008};
  c.promise.gain_margin = {5.0, 4.0, std::numeric_limits<double>::infinity()};
  c.fault = {.following_error_in = 0.02, .swing_V = 0.5, .swings_per_s = 6.0};
  c.provenance = {.model = "/data/a \"b\"\\c.json",
                  .model_sha256 = "00ff",
                  .rig = "bench",
                  .rig_file = "rig.toml",
                  .rig_sha256 = "ff00",
                  .twin = "estimated",
                  .run = "unknown",
                  .made_by = "eha 0"};
  return c;
}

TEST(ControllerFile, IsReadAsItWasWritten) {
  const ControllerConfig written = controller();
  const std::string text = controller_text(written);
  const ControllerConfig read = parse_controller(text, "c.toml");
  EXPECT_EQ(read.name, "axis");
  EXPECT_EQ(read.purpose, "hold");
  EXPECT_EQ(read.settings, written.settings);
  EXPECT_EQ(read.promise.following_rms_in.upper, 0.0008);
  EXPECT_EQ(read.promise.gain_margin.upper, 1e9);
  EXPECT_EQ(read.promise.twins, 50);
  EXPECT_EQ(read.fault.swing_V, 0.5);
  EXPECT_EQ(read.provenance.model, written.provenance.model);
  EXPECT_EQ(controller_text(read).size(), text.size());
  EXPECT_EQ(kind_of(text, "c.toml"), FileKind::controller);
}

std::string refusal(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  try {
    static_cast<void>(parse_controller(text, "c.toml"));
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ControllerFile, NamesLineAndColumnOfWhatIsWrong) {
  const std::string text = controller_text(controller());
  EXPECT_EQ(refusal(text, "kp_per_s = 12.3456789012345", "kp_per_s = \"fast\""),
            "c.toml:15:12: feedback.kp_per_s: expected a number of at least 0, got \"fast\"");
  EXPECT_NE(refusal(text, "smoothing_in_per_s", "smoothing_in_pers").find("did you mean \"smoothing_in_per_s\"?"),
            std::string::npos);
  EXPECT_NE(refusal(text, "position = \"in\"", "position = \"mm\"").find("units.position"), std::string::npos);
  EXPECT_NE(refusal(text, "schema = 1", "schema = 2").find("c.toml:3:"), std::string::npos);
  EXPECT_NE(refusal(text, "velocity_in_per_s = 0.4", "velocity_in_per_s = -0.4").find("c.toml:"), std::string::npos);
  EXPECT_NE(refusal(text, "[fault]", "[faults]").find("fault"), std::string::npos);
  EXPECT_NE(refusal(text, "jerk_in_per_s3 = 25.0", "jerk_in_per_s3 = 0.001").find("jerk"), std::string::npos);
}

TEST(ControllerFile, HasNoNumberOfWhichATickMakesNone) {
  const std::string text = controller_text(controller());
  for (const char* huge : {"1e308", "inf", "nan", "2e9"}) {
    EXPECT_NE(refusal(text, "kp_per_s = 12.3456789012345", std::string("kp_per_s = ") + huge).find("kp"),
              std::string::npos)
        << huge;
    EXPECT_NE(refusal(text, "rest_in = 2.9", std::string("rest_in = -") + huge), "") << huge;
  }
  EXPECT_NE(refusal(text, "gain_negative_in_per_V_s = 0.13", "gain_negative_in_per_V_s = 1e-300").find("gain"),
            std::string::npos);
  EXPECT_NE(refusal(text, "tick_s = 0.002", "tick_s = -0.002"), "");
}

TEST(TrackExperiment, KeepsNameAndTextOfAStrangersFileAsValues) {
  const std::string name = "a\"\n[excitation]\nkind = \"sine";
  const std::string text = "# '''\n[excitation]\nx = \"\"\"'''\\\t\x01\n\"";
  const std::string experiment = track_experiment(name, text, {.step_in = 0.5});
  const Document document = parse_document(experiment, "track.toml");
  EXPECT_EQ(document.root.size(), 3U) << experiment;
  EXPECT_EQ(document.root["name"].value<std::string>(), "track-a---excitation--kind----sine");
  EXPECT_EQ(document.root["track"]["controller"].value<std::string>(), text);
  EXPECT_EQ(document.root["track"]["step_in"].value<double>(), 0.5);
}

}  // namespace
}  // namespace eha::config
