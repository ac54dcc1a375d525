// SPDX-License-Identifier: GPL-3.0-or-later
// The rod between two runs, where the hydraulics are off: the built programs on the stand-in card.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/error.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/driven_rig.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

class RodBetweenRuns : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = DrivenRig::obstacle(); !why.empty()) GTEST_SKIP() << why;
  }
  /// Moves the rod, or its reading, once the hydraulics have gone on and off again.
  std::jthread slip_after_first_run(double by_in) {
    return std::jthread([this, by_in](const std::stop_token& end) {
      while (!end.stop_requested()) {
        const CardMemory& card = rig_.card();
        if (card.enabled_ns > 0 && card.disabled_ns > card.enabled_ns) {
          rig_.card().position_in += by_in;
          return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }

  DrivenRig rig_;
};

/// Presses and resets the emergency stop of a card.
void press_emergency_stop(CardMemory& card, std::chrono::milliseconds held) {
  card.digital_inputs = 0;
  std::this_thread::sleep_for(held);
  card.digital_inputs = 1;
}

class LocalRodBetweenRuns : public RodBetweenRuns {
 protected:
  int run(const std::vector<std::string>& files, const std::string& more_of_rig = "") {
    folder_.write("rig.toml", DrivenRig::rig_text(std::nullopt) + more_of_rig);
    std::vector<std::string> words{EHA_PROGRAM, "run", "--local", "--yes", "--allow-non-realtime", "--rig", "rig.toml"};
    words.insert(words.end(), files.begin(), files.end());
    Driver driver(words, rig_.environment(), folder_.path());
    const int code = driver.wait();
    said_ = driver.messages();
    return code;
  }

  TemporaryFolder folder_;
  std::string said_;
};

TEST_F(LocalRodBetweenRuns, IsComparedWithTheEndOfTheRunBefore) {
  folder_.write("a.toml", quiet_experiment_text("a", 8.0));
  folder_.write("b.toml", quiet_experiment_text("b", 2.0));
  {
    const std::jthread slip = slip_after_first_run(-1.5);
    EXPECT_EQ(run({"a.toml", "b.toml"}), static_cast<int>(ExitCode::device_unavailable)) << said_;
  }
  EXPECT_NE(said_.find("the rod's reading has moved by -1.5 in since the run before"), std::string::npos) << said_;
  EXPECT_NE(said_.find("not played, because the first of them was refused: b.toml"), std::string::npos) << said_;
  rig_.reset();
  EXPECT_EQ(said_.find("b: 2 s"), said_.rfind("b: 2 s")) << said_;
  EXPECT_NE(run({"a.toml", "b.toml"}), static_cast<int>(ExitCode::device_unavailable)) << said_;
}

TEST_F(LocalRodBetweenRuns, IsNotDrivenAfterAnEmergencyStopThatWasReset) {
  folder_.write("a.toml", quiet_experiment_text("a", 2.0));
  folder_.write("b.toml", quiet_experiment_text("b", 2.0));
  {
    const std::jthread person([this](const std::stop_token& end) {
      CardMemory& card = rig_.card();
      while (!end.stop_requested() && card.disabled_ns <= card.enabled_ns) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      press_emergency_stop(card, std::chrono::seconds(2));
    });
    EXPECT_NE(run({"a.toml", "b.toml"}), 0) << said_;
  }
  EXPECT_NE(said_.find("the emergency-stop circuit was opened while nothing was driven"), std::string::npos) << said_;
  EXPECT_EQ(said_.find("b: 2 s"), std::string::npos) << said_;
  EXPECT_NE(said_.find("not played"), std::string::npos) << said_;
}

TEST_F(LocalRodBetweenRuns, IsNotDrivenWithAContactorThatHasWelded) {
  folder_.write("a.toml", quiet_experiment_text("a", 2.0));
  folder_.write("b.toml", quiet_experiment_text("b", 2.0));
  {
    const std::jthread contactor([this](const std::stop_token& end) {
      CardMemory& card = rig_.card();
      while (!end.stop_requested() && !card.is_enabled()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      card.digital_inputs = 3;  // and stays so
    });
    EXPECT_NE(run({"a.toml", "b.toml"},
                  "\n[comedi.enable_contact]\nsubdevice = 2\nchannel = 1\nactive = \"high\"\nfollows_within_s = 0.3\n"),
              0)
        << said_;
  }
  EXPECT_NE(said_.find("the contactor may be welded"), std::string::npos) << said_;
  EXPECT_EQ(said_.find("b: 2 s"), std::string::npos) << said_;
}

TEST_F(LocalRodBetweenRuns, IsWhereARehearsalBegins) {
  std::string text = quiet_experiment_text("up", 20.0);
  const std::string offset = "offset_V = -0.2";
  text.replace(text.find(offset), offset.size(), "offset_V = 1.0");
  folder_.write("up.toml", text);
  rig_.card().position_in = 5.1;
  EXPECT_EQ(run({"up.toml"}), static_cast<int>(ExitCode::configuration)) << said_;
  EXPECT_EQ(rig_.card().enabled_ns, 0) << said_;
}

class ServiceRodBetweenRuns : public RodBetweenRuns {
 protected:
  void SetUp() override {
    RodBetweenRuns::SetUp();
    if (IsSkipped()) return;
    std::ofstream(daemon_.rig_file()) << DrivenRig::rig_text(std::nullopt);
    for (std::string variable : rig_.environment()) {
      const std::string loaded = "LD_PRELOAD=";
      if (variable.starts_with(loaded)) variable.insert(loaded.size(), std::string(EHA_HOST_TRAP_LIBRARY) + ":");
      daemon_.set_environment(variable);
    }
    daemon_.set_environment("EHA_TRAP_HANGS=" + hangs().string());
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
    client_->call("arm");
  }
  [[nodiscard]] pid_t guard() const {
    for (const auto& task : fs::directory_iterator(fmt::format("/proc/{}/task", daemon_.pid()))) {
      std::istringstream children(content_of(task.path() / "children"));
      for (pid_t child = 0; children >> child;) {
        if (content_of(fmt::format("/proc/{}/cmdline", child)).find("eha-safe") != std::string::npos) return child;
      }
    }
    throw std::runtime_error("no guard runs");
  }
  /// Plays an experiment until its files are being written, which hangs. @returns the number of the one that waits
  std::int64_t next_while_the_first_is_written() {
    const std::int64_t first = submit(*client_, quiet_experiment_text("first", 2.0), false);
    const std::int64_t next = submit(*client_, quiet_experiment_text("next", 2.0), false);
    follow(daemon_, first, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
    hang();
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (rig_.card().disabled_ns <= rig_.card().enabled_ns && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_GT(rig_.card().disabled_ns, rig_.card().enabled_ns) << daemon_.log();
    return next;
  }
  [[nodiscard]] fs::path hangs() const { return daemon_.folder() / "hangs"; }
  void hang() const { std::ofstream(hangs()) << "the disk, while this is there"; }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
};

TEST_F(ServiceRodBetweenRuns, IsNotDrivenWhereItMovesWhileTheFolderIsMade) {
  hang();
  const std::int64_t entry = submit(*client_, quiet_experiment_text("next", 2.0), false);
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (entry_of(daemon_, entry).at("state") != "running" && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  rig_.card().position_in -= 1.5;
  EXPECT_TRUE(daemon_.logs("the rod's reading moved by -1.5 in while nothing drove it")) << daemon_.log();
  fs::remove(hangs());
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "refused");
  EXPECT_EQ(over.at("note").get<std::string>().rfind("the rod's reading moved by -1.5 in", 0), 0U) << over;
  EXPECT_EQ(rig_.card().enabled_ns, 0);
  // A script that arms and goes on is stopped once, for a person to look.
  EXPECT_EQ(refused(*client_, "arm").message.rfind("not armed: the rod's reading moved by -1.5 in", 0), 0U);
  EXPECT_EQ(refused(*client_, "arm").message, "");
}

TEST_F(ServiceRodBetweenRuns, IsNotDrivenWhereItMovesBetweenTheLastReadingAndTheFirstTick) {
  // The journal and the first manifest are made in between.
  const fs::path hangs_there = hangs().string() + ".manifest";
  std::ofstream(hangs_there) << "the disk, while this is there";
  const std::int64_t entry = submit(*client_, quiet_experiment_text("next", 2.0), false);
  const auto has_journal = [this] {
    std::error_code ignored;
    for (const auto& run : fs::directory_iterator(daemon_.runs(), ignored)) {
      if (fs::exists(run.path() / "raw.ehalog", ignored)) return true;
    }
    return false;
  };
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (!has_journal() && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  rig_.card().position_in -= 1.5;
  fs::remove(hangs_there);
  const Json over = follow(daemon_, entry);
  EXPECT_EQ(over.at("outcome"), "refused") << over;
  EXPECT_NE(over.at("note").get<std::string>().find("the rod's reading moved by -1.5 in"), std::string::npos) << over;
  EXPECT_EQ(rig_.card().enabled_ns, 0);
  EXPECT_TRUE(daemon_.logs("the rod's reading moved by -1.5 in while nothing drove it: look at the rod"))
      << daemon_.log();
  EXPECT_EQ(refused(*client_, "arm").message.rfind("not armed: the rod's reading moved", 0), 0U);
  EXPECT_EQ(refused(*client_, "arm").message, "");
}

TEST_F(ServiceRodBetweenRuns, IsComparedWithTheEndOfTheRunOnceItsFilesAreWritten) {
  const std::int64_t next = next_while_the_first_is_written();
  rig_.card().position_in -= 1.5;
  const std::int64_t before_ns = rig_.card().enabled_ns;
  fs::remove(hangs());
  EXPECT_TRUE(daemon_.logs("the rod's reading moved by -1.5 in while nothing drove it")) << daemon_.log();
  EXPECT_EQ(entry_of(daemon_, next).at("state"), "held") << daemon_.log();
  EXPECT_EQ(rig_.card().enabled_ns, before_ns);
}

TEST_F(ServiceRodBetweenRuns, IsNotDrivenAfterAnEmergencyStopThatWasReset) {
  const std::int64_t next = next_while_the_first_is_written();
  const std::int64_t before_ns = rig_.card().enabled_ns;
  press_emergency_stop(rig_.card(), std::chrono::seconds(2));  // while the files of the run are written
  fs::remove(hangs());
  EXPECT_TRUE(daemon_.logs("the emergency-stop circuit was opened while nothing was driven")) << daemon_.log();
  EXPECT_EQ(entry_of(daemon_, next).at("state"), "held") << daemon_.log();
  EXPECT_EQ(rig_.card().enabled_ns, before_ns);
  EXPECT_EQ(refused(*client_, "arm").message, "");
}

/// The volts of 1700 tones take a second or so, between the last file and the first tick.
TEST_F(ServiceRodBetweenRuns, IsNotDrivenAfterAnEmergencyStopThatWasResetWhileTheVoltsWereComputed) {
  std::string tones;
  for (int k = 1; k <= 1700; ++k) {
    tones += fmt::format("{{ frequency_Hz = {:.4f}, amplitude_V = 0.0001, phase_rad = 0.0 }},\n", k / 60.0);
  }
  const std::string text =
      "schema = 1\nname = \"heavy\"\nduration_s = 60.0\n[excitation]\nkind = \"multisine\"\noffset_V = 0.0\ntones = "
      "[\n" +
      tones + "]\n[record]\ndiscard_s = 0.0\n";
  const std::int64_t entry = submit(*client_, text, false);
  const auto deadline = std::chrono::steady_clock::now() + kGenerous;
  while (fs::is_empty(daemon_.runs()) && std::chrono::steady_clock::now() < deadline) std::this_thread::yield();
  EXPECT_EQ(rig_.card().enabled_ns, 0) << "the folder is made before the volts";
  press_emergency_stop(rig_.card(), std::chrono::milliseconds(200));
  EXPECT_TRUE(daemon_.logs("the emergency-stop circuit was opened")) << daemon_.log();
  follow(daemon_, entry, [](const Json& snapshot) { return snapshot.at("state") == "over"; });
  EXPECT_EQ(entry_of(daemon_, entry).at("outcome"), "refused") << daemon_.log();
  EXPECT_EQ(rig_.card().enabled_ns, 0) << daemon_.log();
  EXPECT_NE(client_->call("status").at("state"), "armed");
}

TEST_F(ServiceRodBetweenRuns, IsDisarmedByAnEmergencyStopThoughNothingIsQueued) {
  press_emergency_stop(rig_.card(), std::chrono::seconds(2));
  EXPECT_TRUE(daemon_.logs("the emergency-stop circuit was opened while nothing was driven")) << daemon_.log();
  EXPECT_NE(client_->call("status").at("state"), "armed");
  EXPECT_EQ(refused(*client_, "arm").message, "");
}

TEST_F(ServiceRodBetweenRuns, IsComparedWhereArmingOpensTheCardAnew) {
  client_->call("disarm");
  kill(guard(), SIGKILL);
  EXPECT_TRUE(daemon_.logs("the guard of the rig")) << daemon_.log();
  {
    const std::int64_t before_ns = rig_.card().output_ns;
    const std::jthread slip([&](const std::stop_token& end) {
      while (!end.stop_requested() && rig_.card().output_ns == before_ns) std::this_thread::yield();
      rig_.card().position_in -= 1.5;
    });
    const Refused refusal = refused(*client_, "arm");
    EXPECT_NE(refusal.message.find("moved by -1.5 in while nothing drove it: nothing is driven"), std::string::npos)
        << refusal.message << daemon_.log();
  }
  EXPECT_EQ(refused(*client_, "arm").message, "") << "as it stands now";
}

}  // namespace
}  // namespace eha::test
