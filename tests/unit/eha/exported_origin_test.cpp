// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/exported_origin.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/code_text.hpp"
#include "tests/unit/hostile_text.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::cli {
namespace {

TEST(ExportedOrigin, SaysOfWhichFileRigAndModelAControllerIsAndWhatItPromises) {
  const test::TemporaryFolder folder;
  config::ControllerConfig controller;
  controller.name = "axis";
  controller.provenance = {.model = "/runs/x/models/io.json",
                           .model_sha256 = "abc",
                           .rig = "bench",
                           .rig_file = "/etc/ehad/rig.toml",
                           .rig_sha256 = "def",
                           .twin = "itself",
                           .run = "/runs/x",
                           .made_by = "eha 0.1.0"};
  controller.promise.following_rms_in.upper = 0.00103;
  controller.promise.phase_margin_deg.lower = 68.4;
  const auto file = folder.write("axis.toml", "x = 1\n");
  const std::string text = fmt::format("{}", fmt::join(origin_lines(file, controller, DisplayUnit("in")), "\n"));
  EXPECT_EQ(text.rfind("SHA-256 9e26", 0), 0U) << text;
  EXPECT_NE(text.find(" of axis.toml, written 20"), std::string::npos) << text;
  EXPECT_NE(text.find("Rig bench, its file rig.toml, SHA-256 def"), std::string::npos) << text;
  EXPECT_NE(text.find("Model io.json of run x, SHA-256 abc"), std::string::npos) << text;
  EXPECT_NE(text.find("following error at most 0.00103 in RMS"), std::string::npos) << text;
  EXPECT_NE(text.find("phase margin at least 68.4 deg"), std::string::npos) << text;
  EXPECT_NE(text.find("Made by eha 0.1.0"), std::string::npos) << text;
}

TEST(ExportedOrigin, LetsNoTextOfAFileIntoCode) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("axis.toml", "x = 1\n");
  std::mt19937_64 generator(24);
  for (int i = 0; i < 2000; ++i) {
    config::ControllerConfig controller;
    for (std::string* text : {&controller.provenance.model, &controller.provenance.rig, &controller.provenance.rig_file,
                              &controller.provenance.run, &controller.provenance.made_by}) {
      *text = test::hostile(generator, 60);
    }
    for (const std::string& line : origin_lines(file, controller, DisplayUnit("in"))) {
      ASSERT_EQ(line, code_text(line, line.size())) << i;
    }
  }
}

}  // namespace
}  // namespace eha::cli
