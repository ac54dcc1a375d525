// SPDX-License-Identifier: GPL-3.0-or-later
// Runs that are kept when the disk budget is exceeded.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// The model that experiment_text() asks for.
constexpr const char* kIntegrator =
    "structure = \"terms\"\ndenominator = [{ order = 1.0 }, { order = 0.0, coefficient = 0.0 }]\n";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("the experiment has no " + what);
  return text.replace(at, what.size(), by);
}

/// A run that was played, its model rejected: no model of this plant reaches that. The paper's procedure ends after one
/// fit; the default one would go on to other starts and structures, which takes seconds.
std::string rejected_experiment(const std::string& name) {
  const std::string text =
      replaced(experiment_text(name), "min_validation_r2_percent = 90.0", "min_validation_r2_percent = 99.999999");
  return replaced(replaced(text, "procedure = \"both\"", "procedure = \"paper\""), kIntegrator, "structure = \"io\"\n");
}

/// Every model of it is accepted; a shorter record could not be judged.
std::string accepted_experiment(const std::string& name) {
  return replaced(
      replaced(experiment_text(name, 40.0), "min_validation_r2_percent = 90.0", "min_validation_r2_percent = 0.0"),
      "require_stable = true", "require_stable = false");
}

class ServiceRetention : public ::testing::Test {
 protected:
  /// A run of 4 s takes some 0.87 MB, its report included; one of 40 s 5.95 MB.
  void start(const std::string& budget_GiB) {
    daemon_ = std::make_unique<Daemon>("schema = 1\n[retention]\ndisk_budget_GiB = " + budget_GiB + "\n");
    daemon_->start();
    client_ = std::make_unique<Client>(daemon_->socket());
    client_->call("arm");
  }
  Json play(const std::string& text) { return follow(*daemon_, submit(*client_, text)); }
  fs::path play_rejected(const std::string& name) {
    return play(rejected_experiment(name)).at("folder").get<std::string>();
  }

  std::unique_ptr<Daemon> daemon_;
  std::unique_ptr<Client> client_;
};

TEST_F(ServiceRetention, RemovesTheOldestRejectedRunsBeyondTheNewestTwentyAndNoAcceptedOneOrIncident) {
  start("0.0233");
  const Json accepted = play(accepted_experiment("accepted"));
  ASSERT_EQ(accepted.at("exit_code"), 0) << accepted;
  const Json incident = play(faulting_experiment_text("incident"));
  ASSERT_EQ(incident.at("outcome"), "faulted");
  client_->call("arm");
  std::vector<fs::path> rejected;
  // Retention does not take their order from their names, which begin with the clock's time.
  for (int i = 0; i < 24; ++i) rejected.push_back(play_rejected("rejected-" + std::to_string(i)));
  EXPECT_TRUE(daemon_->logs("removed (")) << daemon_->log();
  EXPECT_FALSE(fs::exists(rejected.front())) << daemon_->log();
  EXPECT_TRUE(fs::exists(rejected[rejected.size() - 20]));
  EXPECT_TRUE(fs::exists(accepted.at("folder").get<std::string>()));
  EXPECT_TRUE(fs::exists(incident.at("folder").get<std::string>()));
}

TEST_F(ServiceRetention, RefusesTheNextRunWhenNoneMayGoAndSaysWhatWouldMakeRoom) {
  start("0.0065");
  const Json accepted = play(accepted_experiment("accepted"));
  ASSERT_EQ(accepted.at("exit_code"), 0) << accepted;
  play_rejected("first");
  play_rejected("second");
  const Json refused_run = play(rejected_experiment("third"));
  EXPECT_EQ(refused_run.at("outcome"), "refused") << refused_run;
  EXPECT_EQ(refused_run.at("exit_code"), static_cast<int>(ExitCode::io));
  const std::string note = refused_run.at("note");
  EXPECT_NE(note.find("1 accepted runs"), std::string::npos) << note;
  EXPECT_NE(note.find("eha runs ack"), std::string::npos) << note;
  // Every run that was measured is still there.
  EXPECT_EQ(client_->call("runs").at("runs").size(), 3U);
  const fs::path folder = accepted.at("folder").get<std::string>();
  const Ended removed = run_eha({"runs", "remove", "latest", "--yes", "--socket", daemon_->socket()}, "/");
  EXPECT_EQ(removed.code, 0) << removed.err;
  EXPECT_NE(removed.out.find(folder.filename().string() + ": removed"), std::string::npos) << removed.out;
  EXPECT_FALSE(fs::exists(folder));
  client_->call("arm");
  EXPECT_EQ(play(rejected_experiment("fourth")).at("outcome"), "completed");
}

TEST_F(ServiceRetention, KeepsAnAcknowledgementAcrossARestart) {
  start("20");
  const Json incident = play(faulting_experiment_text("incident"));
  const std::string run = fs::path(incident.at("folder").get<std::string>()).filename();
  const Ended acknowledged = run_eha({"runs", "ack", run, "--socket", daemon_->socket()}, "/");
  EXPECT_EQ(acknowledged.code, 0) << acknowledged.err;
  EXPECT_EQ(refused(*client_, "ack", {{"run", "../queue"}}).code, static_cast<int>(ExitCode::usage));
  EXPECT_EQ(refused(*client_, "remove", {{"run", ".."}}).code, static_cast<int>(ExitCode::usage));
  client_ = nullptr;
  EXPECT_EQ(daemon_->stop(SIGTERM), 0);
  daemon_->start();
  const Json runs = Client(daemon_->socket()).call("runs").at("runs");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.at(0).at("acknowledged"), true);
}

TEST_F(ServiceRetention, LooksIntoNoOtherRunWhileOneIsPlayedAndFitted) {
  start("20");
  const fs::path first = play_rejected("first");
  // Answered by the thread that keeps account of the runs, after it has done so.
  client_->call("runs");
  const int watch = inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  ASSERT_GE(inotify_add_watch(watch, first.c_str(), IN_OPEN | IN_ACCESS), 0);
  play_rejected("second");
  play_rejected("third");
  std::array<char, 4096> events{};
  EXPECT_EQ(read(watch, events.data(), events.size()), -1) << "a run's cost grows with the number of kept runs";
  close(watch);
}

}  // namespace
}  // namespace eha::test
