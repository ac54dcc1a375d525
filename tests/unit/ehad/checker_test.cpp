// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/ehad/checker.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>

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

TEST(Checker, GoesBeforeAFitWhoseResultNobodyWaitsFor) {
  static_assert(worker::kCheckNice < worker::kFitNice);
  const test::TemporaryFolder folder;
  // Its fifth word is the nice value.
  const std::filesystem::path helper = folder.write("helper.sh", "#!/bin/sh\necho $5\n");
  std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
  Checker checker({.helper = helper, .eha = "eha"});
  std::optional<worker::WorkerEnd> ended;
  checker.add({.experiment = folder.path() / "e.toml", .rig = folder.path() / "r.toml"},
              [&](const worker::WorkerEnd& end) { ended = end; });
  for (int i = 0; !ended && i < 1000; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    checker.poll();
  }
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->output, std::to_string(worker::kCheckNice)) << ended->text;
}

TEST(Checker, SaysWhyACheckWasNotDone) {
  using worker::EndedBy;
  const auto said = [](EndedBy ended_by, const char* text) -> std::string {
    try {
      throw_if_failed({std::nullopt, text, "", ended_by}, kExperiment, kRig);
    } catch (const IoError& error) {
      return error.what();
    }
    return "nothing";
  };
  EXPECT_NE(said(EndedBy::processor_time, "").find("fewer tones"), std::string::npos);
  EXPECT_NE(said(EndedBy::wall_time, "").find("the machine is busy"), std::string::npos);
  EXPECT_NE(said(EndedBy::wall_time, "").find("`eha queue`"), std::string::npos);
  EXPECT_NE(said(EndedBy::signal, "the identification was ended by signal 11 (Segmentation fault)")
                .find("the check was ended by signal 11"),
            std::string::npos);
  EXPECT_NE(said(EndedBy::own_limit, "the identification took more than ehad's RLIMIT_CPU: raise LimitCPU")
                .find("raise LimitCPU"),
            std::string::npos);
}

TEST(Checker, NamesTheFaultOfAListBesideACheckThatTookTooLong) {
  const worker::WorkerEnd late{std::nullopt, "", "", worker::EndedBy::processor_time};
  const worker::WorkerEnd faulty{static_cast<int>(ExitCode::configuration),
                                 "eha: error: /state/check/8/experiment.toml:7:1: beyond the limits"};
  const CheckedFile second{"/state/check/8/experiment.toml", "second.toml"};
  ListFindings findings;
  EXPECT_TRUE(findings.take(late, kExperiment, kRig)) << "the next one is checked, too";
  EXPECT_FALSE(findings.take(faulty, second, kRig));
  try {
    findings.throw_if_any();
    ADD_FAILURE();
  } catch (const ConfigError& error) {
    ASSERT_EQ(error.lines().size(), 2U);
    EXPECT_EQ(error.lines()[0], "second.toml:7:1: beyond the limits");
    EXPECT_TRUE(error.lines()[1].starts_with("mine.toml: not checked: the check takes more than 30 s"));
  }
}

TEST(Checker, EndsAListWhoseChecksTakeTooLong) {
  const worker::WorkerEnd late{std::nullopt, "", "", worker::EndedBy::wall_time};
  ListFindings findings;
  EXPECT_TRUE(findings.take({0, ""}, kExperiment, kRig));
  EXPECT_NO_THROW(findings.throw_if_any());
  EXPECT_TRUE(findings.take(late, kExperiment, kRig));
  EXPECT_FALSE(findings.take(late, kExperiment, kRig));
  EXPECT_THROW(findings.throw_if_any(), IoError);
}

/// Checks whose processes say that they are on, and end when they may.
class Checks {
 public:
  void add(char name, uid_t user, bool is_urgent = false) {
    checker_.add({.user = user, .experiment = std::string(1, name), .rig = "r.toml", .is_urgent = is_urgent},
                 [this, name](const worker::WorkerEnd&) { order_ += name; });
  }
  [[nodiscard]] bool is_on(char name) {
    return comes_true([&] { return std::filesystem::exists(folder_.path() / (std::string("on-") + name)); });
  }
  void let_end(char name) { folder_.write(std::string("end-") + name, ""); }
  /// @returns the names in the order of their ends
  const std::string& order_of(std::size_t count) {
    static_cast<void>(comes_true([&] {
      checker_.poll();
      return order_.size() >= count;
    }));
    return order_;
  }

 private:
  static bool comes_true(const std::function<bool()>& holds) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!holds() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return holds();
  }
  [[nodiscard]] std::filesystem::path helper() const {
    // Its eighth word is the experiment.
    const std::filesystem::path script =
        folder_.write("helper.sh", "#!/bin/sh\ncd '" + folder_.path().string() +
                                       "'\n: >on-$8\nwhile [ ! -e end-$8 ]; do sleep 0.01; done\n");
    std::filesystem::permissions(script, std::filesystem::perms::owner_all);
    return script;
  }

  test::TemporaryFolder folder_;
  std::string order_;
  Checker checker_{{helper(), "eha"}};
};

TEST(Checker, KeepsTheOrderOfOneUserAndLetsAnUrgentCheckWaitForNone) {
  Checks checks;
  for (const char name : {'a', 'b', 'c'}) checks.add(name, 1000);
  checks.add('u', 1000, true);
  EXPECT_TRUE(checks.is_on('a'));
  EXPECT_TRUE(checks.is_on('u'));
  checks.let_end('u');
  EXPECT_EQ(checks.order_of(1), "u");
  for (const char name : {'c', 'b', 'a'}) checks.let_end(name);
  EXPECT_EQ(checks.order_of(4), "uabc");
}

TEST(Checker, LetsNoUserWaitForAllThatAnotherHasSubmitted) {
  Checks checks;
  for (char name = 'a'; name < 'a' + 20; ++name) checks.add(name, 1000);
  checks.add('X', 1001);
  EXPECT_TRUE(checks.is_on('X')) << "while the first of the other user goes on";
  checks.add('Y', 1002);
  checks.add('Z', 1001);
  for (char name = 'a'; name < 'a' + 20; ++name) checks.let_end(name);
  // The first user's checks went on for a while by then; Y's user has had none.
  EXPECT_TRUE(checks.order_of(1).starts_with("a")) << checks.order_of(1);
  EXPECT_TRUE(checks.is_on('Y')) << checks.order_of(1);
  for (const char name : {'X', 'Y', 'Z'}) checks.let_end(name);
  const std::string order = checks.order_of(23);
  EXPECT_EQ(order.size(), 23U);
  EXPECT_LT(order.find('X'), order.find('Z'));
  EXPECT_LT(order.find('b'), order.find('c'));
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
