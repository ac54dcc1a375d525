// SPDX-License-Identifier: GPL-3.0-or-later
// A stalled thread of the service: the test stops each thread alone, as a debugger does.
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/wait.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <thread>

#include "daemon/record/journal.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/daemon.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;
using namespace std::chrono_literals;

std::optional<pid_t> thread_named(pid_t pid, const std::string& name) {
  for (const auto& task : fs::directory_iterator(fs::path("/proc") / std::to_string(pid) / "task")) {
    std::ifstream comm(task.path() / "comm");
    std::string line;
    if (std::getline(comm, line) && line == name) return std::stoi(task.path().filename().string());
  }
  return std::nullopt;
}

/// Halts one thread of a child process while it lives.
class Halted {
 public:
  explicit Halted(pid_t thread) : thread_(thread) {
    is_ours_ = ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) == 0;
    if (!is_ours_) return;
    ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr);
    int status = 0;
    waitpid(thread_, &status, __WALL);
  }
  Halted(const Halted&) = delete;
  Halted& operator=(const Halted&) = delete;
  ~Halted() {
    if (is_ours_) ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
  }
  [[nodiscard]] bool works() const { return is_ours_; }

 private:
  pid_t thread_;
  bool is_ours_ = false;
};

class ServiceStall : public ::testing::Test {
 protected:
  void SetUp() override {
    daemon_.start();
    client_ = std::make_unique<Client>(daemon_.socket());
    client_->call("arm");
    entry_ = submit(*client_, quiet_experiment_text("long", 600.0), false);
    follow(daemon_, entry_, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  }

  bool reaches(const std::string& state) {
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (std::chrono::steady_clock::now() < deadline) {
      if (client_->call("status").at("state") == state) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }

  Daemon daemon_;
  std::unique_ptr<Client> client_;
  std::int64_t entry_ = 0;
};

TEST_F(ServiceStall, OfTheWriterFailsTheRunAfterSixSecondsAndTheWatchdogAfterTen) {
  const auto thread = thread_named(daemon_.pid(), "eha-writer");
  ASSERT_TRUE(thread);
  {
    const Halted writer(*thread);
    if (!writer.works()) GTEST_SKIP() << "this user may not trace its own children";
    // The command is ramped out while the writer still hangs; then nobody feeds the watchdog.
    EXPECT_TRUE(reaches("idle"));
    EXPECT_EQ(entry_of(daemon_, entry_).at("state"), "running");
    EXPECT_TRUE(daemon_.logs("the writer of the record stands still"));
  }
  const Json over = follow(daemon_, entry_);
  EXPECT_EQ(over.at("outcome"), "write_failed") << over;
  EXPECT_EQ(client_->call("status").at("state"), "idle");
}

TEST_F(ServiceStall, OfTheWriterForFiveSecondsCostsNoTickAndIsInTheRecord) {
  constexpr std::chrono::seconds kStall(5);
  const auto thread = thread_named(daemon_.pid(), "eha-writer");
  ASSERT_TRUE(thread);
  {
    const Halted writer(*thread);
    if (!writer.works()) GTEST_SKIP() << "this user may not trace its own children";
    std::this_thread::sleep_for(kStall);
  }
  EXPECT_EQ(client_->call("status").at("state"), "running");
  client_->call("stop");
  const Json over = follow(daemon_, entry_);
  EXPECT_EQ(over.at("outcome"), "interrupted") << over;
  const fs::path run = over.at("folder").get<std::string>();
  const Json counters = Json::parse(content_of(run / "run.json")).at("report").at("counters");
  EXPECT_EQ(counters.at("dropped"), 0);
  // The records of that time waited for the writer, which then wrote them. The machine may have lost some ticks.
  EXPECT_GE(counters.at("queue_peak").get<std::int64_t>() + counters.at("skipped").get<std::int64_t>(),
            std::chrono::milliseconds(kStall - 100ms).count());
  std::int64_t rows = 0;
  record::read_journal(run / record::kJournalFile, [&](auto records) { rows += std::ssize(records); });
  EXPECT_EQ(rows, counters.at("ticks").get<std::int64_t>() + counters.at("skipped").get<std::int64_t>());
}

TEST_F(ServiceStall, OfTheLoopWithholdsTheWatchdog) {
  const auto thread = thread_named(daemon_.pid(), "eha-loop");
  ASSERT_TRUE(thread);
  {
    const Halted loop(*thread);
    if (!loop.works()) GTEST_SKIP() << "this user may not trace its own children";
    EXPECT_TRUE(daemon_.logs("the loop stands still"));
    // A fed watchdog would be notified each second.
    daemon_.forget_messages();
    EXPECT_FALSE(daemon_.hears("WATCHDOG=1", std::chrono::seconds(3)));
    // Everyone is still answered.
    EXPECT_EQ(client_->call("status").at("state"), "running");
  }
  EXPECT_TRUE(daemon_.hears("WATCHDOG=1"));
}

}  // namespace
}  // namespace eha::test
