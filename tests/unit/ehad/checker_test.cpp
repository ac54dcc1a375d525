// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/checker.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::service {
namespace {

const CheckedFile kExperiment{"/state/check/7/experiment.toml", "mine.toml"};
const CheckedFile kRig{"/state/check/7/rig.toml", "/etc/ehad/rig.toml"};

TEST(Checker, PassesASoundExperiment) { EXPECT_NO_THROW(throw_if_failed({0, ""}, kExperiment, kRig)); }

TEST(Checker, NamesEveryFaultAndFileAsTheClientKnowsThem) {
  const worker::WorkerEnd end{static_cast<int>(ExitCode::configuration),
                              "eha: error: /state/check/7/experiment.toml:1:2: a\n"
                              "eha: error: /state/check/7/experiment.toml:3:4: beyond the limits of "
                              "/state/check/7/rig.toml"};
  try {
    throw_if_failed(end, kExperiment, kRig);
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.lines(),
              (std::vector<std::string>{"mine.toml:1:2: a", "mine.toml:3:4: beyond the limits of /etc/ehad/rig.toml"}));
  }
}

TEST(Checker, ReadsTheRehearsalOfACheck) {
  const worker::WorkerEnd end{0, "", R"({"schema":"eha-check/1","rehearsal":{"lowest_in":2.5,"chance_of_trip":0.0}})"};
  EXPECT_EQ(rehearsal_of(end).at("lowest_in"), 2.5);
  EXPECT_TRUE(rehearsal_of({0, "", R"({"schema":"eha-check/1"})"}).is_null());
  EXPECT_TRUE(rehearsal_of({0, "", "torn"}).is_null());
}

TEST(Checker, SaysThatACheckWasTooLong) {
  try {
    throw_if_failed({std::nullopt, "killed"}, kExperiment, kRig);
    ADD_FAILURE();
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("fewer tones"), std::string::npos);
  }
}

TEST(Checker, TakesAnUrgentCheckNextAndEndsTheOneThatIsOnFirst) {
  const test::TemporaryFolder folder;
  const std::filesystem::path helper = folder.write(
      "helper.sh", "#!/bin/sh\nwhile [ ! -e " + (folder.path() / "go").string() + " ]; do sleep 0.01; done\n");
  std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
  Checker checker({helper, helper});
  std::string order;
  const auto add = [&](char name, bool is_urgent) {
    checker.add({.experiment = "e.toml", .rig = "r.toml", .is_urgent = is_urgent},
                [&order, name](const worker::WorkerEnd&) { order += name; });
  };
  add('a', false);
  add('b', false);
  add('c', false);
  add('u', true);
  folder.write("go", "");
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (order.size() < 4 && std::chrono::steady_clock::now() < deadline) checker.poll();
  EXPECT_EQ(order, "aubc");
}

TEST(Checker, ReportsACheckThatCannotBeStarted) {
  Checker checker({"/no/such/helper", "/no/such/eha"});
  int code = -1;
  checker.add({.experiment = "e.toml", .rig = "r.toml"},
              [&](const worker::WorkerEnd& end) { code = end.exit_code.value_or(-2); });
  EXPECT_EQ(code, static_cast<int>(ExitCode::io));
}

}  // namespace
}  // namespace eha::service
