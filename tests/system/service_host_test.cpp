// SPDX-License-Identifier: GPL-3.0-or-later
// Disturbances by the host: a log that nobody reads, user look-ups that hang, experiments that take minutes to check.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"
#include "tests/system/stalled_reader.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;
using std::chrono::steady_clock;

/// Longest wait for the answer to a stop on a loaded machine.
constexpr std::chrono::seconds kPrompt(5);

std::int64_t start_long_run(const Daemon& daemon, Client& client) {
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  return entry;
}

TEST(ServiceHost, AStalledReaderOfTheLogDelaysNeitherAStopNorTheEnd) {
  Daemon daemon;
  const StalledReader reader(daemon.folder() / "pipe");
  daemon.set_log(daemon.folder() / "pipe");
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t entry = start_long_run(daemon, client);
  reader.fill();
  const auto begun = steady_clock::now();
  EXPECT_EQ(client.call("stop").at("stopped"), "ramping_out");
  EXPECT_LT(steady_clock::now() - begun, kPrompt);
  EXPECT_EQ(follow(daemon, entry).at("outcome"), "interrupted");
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
}

TEST(ServiceHost, ALogThatIsReadAgainSaysHowManyMessagesWereDropped) {
  Daemon daemon;
  const StalledReader reader(daemon.folder() / "pipe");
  daemon.set_log(daemon.folder() / "pipe");
  daemon.start();
  reader.fill();
  Client client(daemon.socket());
  // Each pair logs two messages of the state, independently of the limit on those of requests.
  for (int i = 0; i < 1000; ++i) {
    client.call("arm");
    client.call("disarm");
  }
  std::string log;
  const auto deadline = steady_clock::now() + kGenerous;
  while (log.find("log messages were dropped") == std::string::npos && steady_clock::now() < deadline) {
    log += reader.drain();
    client.call("status");
  }
  EXPECT_NE(log.find("log messages were dropped"), std::string::npos);
}

TEST(ServiceHost, AUserLookUpThatHangsDelaysNobody) {
  if (!can_change_user()) GTEST_SKIP() << "needs root, to connect as a user who is in no file";
  Daemon daemon;
  daemon.set_environment(std::string("LD_PRELOAD=") + EHA_HOST_TRAP_LIBRARY);
  daemon.set_environment("EHA_TRAP_LOOKUP_S=20");
  daemon.start();
  daemon.open_to_all();
  const auto begun = steady_clock::now();
  constexpr uid_t kStranger = 54321;
  const auto stranger = connect_as(kStranger, daemon);
  EXPECT_EQ(stranger->call("arm").at("state"), "armed");
  EXPECT_EQ(Client(daemon.socket()).call("stop").at("stopped"), "disarmed");
  EXPECT_TRUE(daemon.logs("armed by 54321 (uid 54321")) << daemon.log();
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
  EXPECT_LT(steady_clock::now() - begun, kPrompt);
}

/// So many tones that are not harmonics, over so long a time that the table takes minutes.
std::string endless_experiment_text(double duration_s = 9000.0) {
  std::string text = experiment_text("endless", duration_s);
  const std::string key = "tones = [\n";
  const std::size_t begin = text.find(key);
  if (begin == std::string::npos) throw std::runtime_error("the experiment has no tones");
  std::string tones;
  for (int i = 0; i < 2000; ++i) {
    tones += "{frequency_Hz=" + std::to_string(0.1 + 0.00137 * i) + ",amplitude_V=0.0001,phase_rad=0},\n";
  }
  return text.insert(begin + key.size(), tones);
}

TEST(ServiceHost, AnExperimentThatTakesMinutesToCheckDelaysNeitherOthersNorTheEnd) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::jthread submitter([&daemon] {
    try {
      Client other(daemon.socket());
      other.call("submit", {{"experiment", endless_experiment_text()}, {"name", "e.toml"}, {"fast", true}});
    } catch (const Error&) {
      // The service ends before it has an answer.
    }
  });
  EXPECT_TRUE(daemon.logs("submit by")) << daemon.log();
  const auto begun = steady_clock::now();
  EXPECT_EQ(client.call("runs").at("runs").size(), 0U);
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
  EXPECT_LT(steady_clock::now() - begun, kPrompt);
}

TEST(ServiceHost, AnExperimentThatWasCheckedOverAStopWaitsForItsRelease) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  std::int64_t entry = 0;
  {
    const std::jthread submitter([&] {
      Client other(daemon.socket());
      entry =
          other
              .call(
                  "submit",
                  {{"experiment", endless_experiment_text(4.0)}, {"name", "e.toml"}, {"detach", true}, {"fast", true}})
              .at("entry");
    });
    EXPECT_TRUE(daemon.logs("submit by")) << daemon.log();
    client.call("stop");
    EXPECT_EQ(client.call("arm").at("state"), "armed");
  }
  const Json checked = entry_of(daemon, entry);
  EXPECT_EQ(checked.at("state"), "held") << checked;
  EXPECT_EQ(checked.at("note"), "the rig was disarmed while it was checked") << checked;
  client.call("release", {{"entry", entry}});
  EXPECT_NE(entry_of(daemon, entry).at("state"), "held");
  client.call("stop");
}

/// A service whose disk hangs at the folder of a run, for as long as a file is there.
class ServiceWithAHangingDisk : public ::testing::Test {
 protected:
  void SetUp() override {
    daemon_.set_environment(std::string("LD_PRELOAD=") + EHA_HOST_TRAP_LIBRARY);
    daemon_.set_environment("EHA_TRAP_HANGS=" + hangs().string());
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
    client_->call("arm");
    std::ofstream(hangs()) << "while this is there";
  }
  [[nodiscard]] fs::path hangs() const { return daemon_.folder() / "hangs"; }
  bool is_in(std::int64_t entry, const char* state) {
    const auto deadline = steady_clock::now() + kGenerous;
    while (entry_of(daemon_, entry).at("state") != state && steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return entry_of(daemon_, entry).at("state") == state;
  }
  /// Submits an experiment whose connection is lost while its folder is made; the disk then goes on.
  std::int64_t lose_client(bool stops) {
    std::int64_t attached = 0;
    {
      Client other(daemon_.socket());
      attached =
          other.call("submit", {{"experiment", quiet_experiment_text("attached", 2.0)}, {"fast", true}}).at("entry");
      EXPECT_TRUE(is_in(attached, "running"));
      if (stops) client_->call("stop");
    }
    // An answer to what was asked after the loss shows that the service knows of it.
    for (int i = 0; i < 3; ++i) client_->call("status");
    fs::remove(hangs());
    EXPECT_TRUE(is_in(attached, "held")) << entry_of(daemon_, attached);
    EXPECT_EQ(daemon_.log().find("runs in "), std::string::npos) << daemon_.log();
    return attached;
  }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
};

TEST_F(ServiceWithAHangingDisk, TakesARunBackWhoseClientIsLostMeanwhile) {
  lose_client(false);
  EXPECT_EQ(client_->call("status").at("state"), "armed");
}

TEST_F(ServiceWithAHangingDisk, KeepsAStopOfARunThatIsTakenBack) {
  lose_client(true);
  EXPECT_EQ(client_->call("status").at("state"), "idle");
}

TEST(ServiceLog, HasNoLineThatBeginsWithTheTextOfAClient) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  std::string text = experiment_text("bad");
  text.replace(text.find("duration_s"), 10, "duration_x");
  text.replace(text.find("repetitions"), 11, "repetitionz");
  EXPECT_EQ(refused(client, "submit", {{"experiment", text}, {"name", "<0>forged"}}).code,
            static_cast<int>(ExitCode::configuration));
  ASSERT_TRUE(daemon.logs("duration_x")) << daemon.log();
  EXPECT_EQ(daemon.log().find("\n<0>forged"), std::string::npos) << daemon.log();
}

TEST(ServiceLog, IsNotFilledByTheRequestsOfOneUser) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(refused(client, "cancel", {{"entry", 1}}).code, static_cast<int>(ExitCode::usage));
  }
  client.call("arm");
  ASSERT_TRUE(daemon.logs("armed by")) << daemon.log();
  std::size_t lines = 0;
  const std::string log = daemon.log();
  for (std::size_t at = log.find("cancel by"); at != std::string::npos; at = log.find("cancel by", at + 1)) ++lines;
  EXPECT_LT(lines, 200U);
}

}  // namespace
}  // namespace eha::test
