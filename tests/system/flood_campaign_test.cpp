// SPDX-License-Identifier: GPL-3.0-or-later
// Minutes: a run during which everything is asked of the service at once, beside ten runs in peace.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/system/daemon.hpp"
#include "tests/system/stalled_reader.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;
using std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr int kPeacefulRuns = 10;
constexpr int kClients = 300;
constexpr int kSubmitters = 4;  ///< beside them
constexpr int kSubmits = 10'000;
constexpr auto kRun = 6s;
constexpr auto kStopLimit = 50ms;

struct Outcome {
  double late_share = 0.0;
  steady_clock::duration stop_answered{};
};

/// Plays for kRun while `disturb` goes on, then stops.
Outcome play(const Daemon& daemon, const std::function<void(const std::atomic<bool>& over)>& disturb) {
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("long", 600.0), false);
  follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("state") == "running"; });
  std::atomic<bool> over{false};
  Outcome outcome;
  {
    std::jthread disturber([&] { disturb(over); });
    std::this_thread::sleep_for(kRun);
    const auto begun = steady_clock::now();
    // The service may have closed the first connection, idle for so long.
    const Json answer = Client(daemon.socket()).call("stop");
    outcome.stop_answered = steady_clock::now() - begun;
    EXPECT_EQ(answer.at("stopped"), "ramping_out");
    over = true;
  }
  const Json ended = follow(daemon, entry);
  EXPECT_EQ(ended.at("outcome"), "interrupted") << ended;
  const Json run = Json::parse(content_of(fs::path(ended.at("folder").get<std::string>()) / "run.json"));
  const Json counters = run.at("report").at("counters");
  outcome.late_share = (counters.at("late").get<double>() + counters.at("skipped").get<double>()) /
                       (counters.at("ticks").get<double>() + counters.at("skipped").get<double>());
  return outcome;
}

void flood(const Daemon& daemon, const std::atomic<bool>& over, std::atomic<int>& submitted) {
  std::vector<std::unique_ptr<Client>> idle;
  for (int i = 0; i < kClients; ++i) idle.push_back(std::make_unique<Client>(daemon.socket()));
  std::vector<std::jthread> submitters;
  for (int i = 0; i < kSubmitters; ++i) {
    submitters.emplace_back([&] {
      Client client(daemon.socket());
      const std::string text = quiet_experiment_text("flood", 1.0);
      while (!over && submitted.fetch_add(1) < kSubmits) {
        static_cast<void>(refused(client, "submit", {{"experiment", text}, {"name", "flood.toml"}, {"fast", true}}));
      }
    });
  }
}

TEST(Flood, DelaysNeitherAStopNorTheTicks) {
  Daemon daemon;
  const StalledReader reader(daemon.folder() / "pipe");
  daemon.set_log(daemon.folder() / "pipe");
  daemon.start();
  double best = 1.0;
  double worst = 0.0;
  for (int run = 0; run < kPeacefulRuns; ++run) {
    const double share = play(daemon, [](const std::atomic<bool>&) {}).late_share;
    best = std::min(best, share);
    worst = std::max(worst, share);
    static_cast<void>(reader.drain());
  }
  reader.fill();
  std::atomic<int> submitted{0};
  const Outcome flooded = play(daemon, [&](const std::atomic<bool>& over) { flood(daemon, over, submitted); });
  const double stop_ms = std::chrono::duration<double, std::milli>(flooded.stop_answered).count();
  std::printf("late ticks: %.2f %% to %.2f %% in peace, %.2f %% in the flood of %d submits; stop answered in %.1f ms\n",
              1e2 * best, 1e2 * worst, 1e2 * flooded.late_share, submitted.load(), stop_ms);
  EXPECT_GE(submitted.load(), kSubmits);
  EXPECT_LT(flooded.stop_answered, kStopLimit);
  EXPECT_LE(flooded.late_share, worst);
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
}

/// Leaves copies of the only run of a service that is not running, without what a list does not read.
void multiply_run(const Daemon& daemon, int copies) {
  const fs::path run = fs::directory_iterator(daemon.runs())->path();
  Json manifest = Json::parse(content_of(run / "run.json"));
  for (const char* part : {"rig", "experiment", "identification", "files"}) manifest.erase(part);
  for (int i = 0; i < copies; ++i) {
    const fs::path copy = daemon.runs() / fmt::format("20200101T{:06}Z-copy", i);
    fs::create_directory(copy);
    std::ofstream(copy / "run.json") << manifest.dump();
  }
}

TEST(Flood, OfListsOfTwentyThousandRunsDelaysNoStop) {
  constexpr int kRuns = 20'000;
  constexpr int kLists = 60;
  Daemon daemon;
  daemon.start();
  {
    Client client(daemon.socket());
    client.call("arm");
    follow(daemon, submit(client, quiet_experiment_text("short", 1.0), true));
  }
  EXPECT_EQ(daemon.stop(SIGTERM), 0);
  multiply_run(daemon, kRuns);
  daemon.start();
  std::atomic<int> listed{0};
  std::atomic<int> ended{0};
  steady_clock::duration longest{};
  {
    std::vector<std::jthread> lists;
    for (int i = 0; i < kLists; ++i) {
      lists.emplace_back([&] {
        try {
          const Json list = Client(daemon.socket()).call("runs", Json::object(), std::chrono::minutes(5));
          if (list.at("runs").size() > kRuns) ++listed;
        } catch (const Error&) {  // not listed
        }
        ++ended;
      });
    }
    Client client(daemon.socket());
    while (ended < kLists) {
      const auto begun = steady_clock::now();
      client.call("stop");
      longest = std::max(longest, steady_clock::now() - begun);
      std::this_thread::sleep_for(20ms);
    }
  }
  std::printf("stop answered in %.0f ms at most\n", std::chrono::duration<double, std::milli>(longest).count());
  EXPECT_LT(longest, 500ms);
}

}  // namespace
}  // namespace eha::test
