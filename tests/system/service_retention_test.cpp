// SPDX-License-Identifier: GPL-3.0-or-later
// What is kept when the disk budget is passed.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// A run that was played, its models rejected: no model of this plant reaches that.
std::string rejected_experiment(const std::string& name) {
  std::string text = experiment_text(name);
  const std::string key = "min_validation_r2_percent = 90.0";
  return text.replace(text.find(key), key.size(), "min_validation_r2_percent = 99.999999");
}

TEST(ServiceRetention, RemovesTheOldestRejectedRunsAndNeverAnAcceptedOne) {
  // A run of 4 s takes some 0.7 MB: there is room for three.
  Daemon daemon("schema = 1\n[retention]\ndisk_budget_GiB = 0.0022\n");
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const auto play = [&](const std::string& text) {
    const Json over = follow(daemon, submit(client, text));
    EXPECT_EQ(over.at("outcome"), "completed") << over;
    return over;
  };
  // Accepted whatever comes out of such a short record.
  std::string easy = experiment_text("accepted");
  const std::string key = "min_validation_r2_percent = 90.0";
  easy.replace(easy.find(key), key.size(), "min_validation_r2_percent = 0.0");
  const std::string stable = "require_stable = true";
  easy.replace(easy.find(stable), stable.size(), "require_stable = false");
  const Json accepted = play(easy);
  ASSERT_EQ(accepted.at("exit_code"), 0) << accepted;
  const fs::path first = play(rejected_experiment("first")).at("folder").get<std::string>();
  const fs::path second = play(rejected_experiment("second")).at("folder").get<std::string>();
  const fs::path third = play(rejected_experiment("third")).at("folder").get<std::string>();
  EXPECT_TRUE(daemon.logs("removed (")) << daemon.log();
  EXPECT_FALSE(fs::exists(first)) << daemon.log();
  EXPECT_TRUE(fs::exists(third));
  EXPECT_TRUE(fs::exists(accepted.at("folder").get<std::string>()));
  EXPECT_NE(daemon.log().find(first.filename().string() + ": removed ("), std::string::npos) << daemon.log();
}

}  // namespace
}  // namespace eha::test
