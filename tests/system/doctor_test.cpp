// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "core/error.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::test {
namespace {

using nlohmann::json;

/// The check of this name in the document of `eha doctor --json`.
json check_named(const json& document, const std::string& name) {
  const json& checks = document.at("checks");
  const auto found = std::find_if(checks.begin(), checks.end(), [&](const json& c) { return c.at("name") == name; });
  return found == checks.end() ? json() : *found;
}

TEST(Doctor, FindsNothingThatStopsASimulatedRig) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml").string();
  const Ended text = run_eha({"doctor", "--rig", rig}, folder.path());
  EXPECT_EQ(text.code, 0) << text.out << text.err;
  EXPECT_NE(text.out.find("scheduling"), std::string::npos);
  EXPECT_NE(text.out.find("Next: eha latency"), std::string::npos);
  const Ended ended = run_eha({"doctor", "--rig", rig, "--json"}, folder.path());
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("exit_code"), 0);
  EXPECT_EQ(check_named(document, "rig file").at("level"), "ok");
  EXPECT_TRUE(check_named(document, "device").is_null());
}

TEST(Doctor, FailsWithTheRigFilesFaultsAndLooksAtTheRestAllTheSame) {
  const TemporaryFolder folder;
  std::string text = content_of(source_file("config/rigs/pci1716.toml"));
  const std::size_t heartbeat = text.find("[comedi.heartbeat]");
  ASSERT_NE(heartbeat, std::string::npos);
  text.resize(heartbeat);
  folder.write("rig.toml", text);
  const Ended ended = run_eha({"doctor", "--rig", "rig.toml", "--json"}, folder.path());
  EXPECT_EQ(ended.code, static_cast<int>(ExitCode::configuration)) << ended.out << ended.err;
  const json document = json::parse(ended.out);
  EXPECT_EQ(check_named(document, "rig file").at("level"), "fail");
  EXPECT_NE(check_named(document, "rig file").at("found").get<std::string>().find("heartbeat"), std::string::npos);
  EXPECT_FALSE(check_named(document, "kernel").is_null());
  EXPECT_EQ(run_eha({"doctor", "--rig", "none.toml"}, folder.path()).code, static_cast<int>(ExitCode::configuration));
}

TEST(Latency, GivesOneJsonDocumentWithEveryGate) {
  const TemporaryFolder folder;
  const Ended ended = run_eha(
      {"latency", "--duration", "0.2", "--json", "--rig", source_file("config/rigs/sim.toml").string()}, folder.path());
  const json document = json::parse(ended.out);
  EXPECT_EQ(document.at("exit_code"), ended.code);
  const bool passed = document.at("passed").get<bool>();
  EXPECT_EQ(ended.code, static_cast<int>(passed ? ExitCode::ok : ExitCode::deadline)) << ended.err;
  EXPECT_EQ(document.at("gates").size(), 5U);
  EXPECT_GE(document.at("report").at("latency").at("count").get<int>(), 1);
}

TEST(Doctor, PrintsFollowingFromARunAndARigFileTakesIt) {
  const TemporaryFolder folder;
  const std::string rig = source_file("config/rigs/sim.toml").string();
  ASSERT_EQ(
      run_eha({"run", source_file("config/experiments/paper.toml"), "--local", "--fast", "--rig", rig}, folder.path())
          .code,
      0);
  const Ended ended = run_eha({"doctor", "--following", "runs/latest"}, folder.path());
  ASSERT_EQ(ended.code, 0) << ended.err;
  ASSERT_TRUE(ended.out.starts_with("[following]\n")) << ended.out;
  // The lines take the place of the shipped ones.
  std::string text = content_of(rig);
  const std::size_t table = text.find("[following]");
  text.replace(table, text.find("# How ticks are kept.") - table, ended.out.substr(0, ended.out.find("Next:")) + "\n");
  folder.write("rig.toml", text);
  const Ended checked = run_eha({"check", "rig.toml"}, folder.path());
  EXPECT_EQ(checked.code, 0) << checked.err << text;
  const json document = json::parse(run_eha({"doctor", "--following", "runs/latest", "--json"}, folder.path()).out);
  EXPECT_NEAR(document.at("following").at("null_V").get<double>(), -0.2, 0.03);
}

TEST(Doctor, LearnsFollowingFromNoInterruptedOrForeignRun) {
  const TemporaryFolder folder;
  EXPECT_EQ(run_eha({"doctor", "--following", "nowhere"}, folder.path()).code, static_cast<int>(ExitCode::io));
  EXPECT_EQ(run_eha({"doctor", "--following", "nowhere", "--rig", "x.toml"}, folder.path()).code,
            static_cast<int>(ExitCode::usage));
}

}  // namespace
}  // namespace eha::test
