// SPDX-License-Identifier: GPL-3.0-or-later
// The valve sheet of a run beside a running service.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;

TEST(ServiceCharacterise, PutsNoOtherLimitsInForceThanTheOwners) {
  Daemon daemon;
  daemon.start();
  const Ended played = run_eha({"characterise", "--local", "--fast", "--rig", daemon.rig_file().string(), "-o", "runs"},
                               daemon.folder());
  ASSERT_EQ(played.code, 0) << played.err;
  const fs::path run = fs::directory_iterator(daemon.folder() / "runs")->path();
  const auto with = [&](const std::string& old, const std::string& changed) {
    Json manifest = Json::parse(content_of(run / "run.json"));
    auto text = manifest.at("rig").at("text").get<std::string>();
    ASSERT_NE(text.find(old), std::string::npos) << text;
    manifest["rig"]["text"] = text.replace(text.find(old), old.size(), changed);
    std::ofstream(run / "run.json") << manifest.dump();
  };
  const auto sheet = [&](const char* rig_file) {
    return run_eha({"characterise", run.string(), "-o", rig_file, "--socket", daemon.socket().string()},
                   daemon.folder());
  };
  const std::string limit = "velocity_limit_in_per_s = ";
  with(limit, limit + "9");  // of a stranger, or of before
  const Ended ended = sheet("new.toml");
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(content_of(daemon.folder() / "new.toml").find(limit + "9"), std::string::npos);
  EXPECT_NE(ended.err.find("has changed since this run"), std::string::npos) << ended.err;
  EXPECT_NE(ended.out.find("cp new.toml " + daemon.rig_file().string()), std::string::npos) << ended.out;

  EXPECT_EQ(ended.err.find("is not armed"), std::string::npos) << ended.err;
  with("\nscale_in_per_V = 0.6 ", "\nscale_in_per_V = 0.605 ");
  const Ended recalibrated = sheet("recalibrated.toml");
  ASSERT_EQ(recalibrated.code, 0) << recalibrated.err;
  EXPECT_NE(recalibrated.err.find("another calibration than this run"), std::string::npos) << recalibrated.err;

  with("name = \"", "name = \"another ");
  const Ended other = sheet("other.toml");
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_NE(other.err.find("this run is of another rig"), std::string::npos) << other.err;
  EXPECT_EQ(other.out.find(daemon.rig_file().string()), std::string::npos) << other.out;
}

}  // namespace
}  // namespace eha::test
