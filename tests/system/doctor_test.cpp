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

}  // namespace
}  // namespace eha::test
