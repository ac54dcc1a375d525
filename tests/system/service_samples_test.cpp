// SPDX-License-Identifier: GPL-3.0-or-later
// The sample stream of `watch`: nothing lost to a reader that keeps up, gaps said, the client of the manual page.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <string>

#include "daemon/acquisition/tick_record.hpp"
#include "daemon/record/run_folder.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;
using std::chrono::steady_clock;

/// Columns of a block.
enum Column : std::size_t { utc_ns, run_s, displacement_min_in, displacement_max_in, applied_min_V, applied_max_V };

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void add(const Json& value) {
    if (value.is_number()) add(value.get<double>());
  }
  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// A watcher of the samples, which checks that they are numbered without a gap that is not said.
class Follower {
 public:
  explicit Follower(const Daemon& daemon, double rate_Hz = 25.0) : client_(daemon.socket()) {
    client_.call("watch", {{"rate_Hz", rate_Hz}, {"samples", true}});
  }

  /// Waits for the next event and takes its blocks.
  void turn() {
    const std::optional<Json> snapshot = client_.next_event(std::chrono::seconds(1));
    if (!snapshot) return;
    const Json& samples = snapshot->at("samples");
    const auto first = samples.at("first").get<std::uint64_t>();
    lost_ += samples.at("lost").get<std::uint64_t>();
    if (next_ != 0) {
      EXPECT_EQ(first, next_ + samples.at("lost").get<std::uint64_t>());
    }
    for (const Json& block : samples.at("blocks")) {
      if (block.at(run_s).is_null()) {
        ++idle_;
        EXPECT_TRUE(block.at(applied_max_V).is_null()) << block;
        EXPECT_TRUE(block.at(displacement_max_in).is_number()) << block;
        continue;
      }
      ++of_runs_;
      const auto age_ns =
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count() -
          block.at(utc_ns).get<std::int64_t>();
      oldest_s_ = std::max(oldest_s_, static_cast<double>(age_ns) * 1e-9);
      rod_.add(block.at(displacement_min_in));
      rod_.add(block.at(displacement_max_in));
      volts_.add(block.at(applied_min_V));
      volts_.add(block.at(applied_max_V));
    }
    next_ = first + samples.at("blocks").size();
    is_running_ = !snapshot->at("run").is_null();
  }

  Client client_;
  std::uint64_t next_ = 0;
  std::uint64_t lost_ = 0;
  std::size_t idle_ = 0;
  std::size_t of_runs_ = 0;
  bool is_running_ = false;
  double oldest_s_ = 0.0;
  Range rod_;
  Range volts_;
};

bool until(Follower& follower, const std::function<bool()>& done) {
  const auto deadline = steady_clock::now() + kGenerous;
  while (!done() && steady_clock::now() < deadline) follower.turn();
  return done();
}

TEST(ServiceSamples, HoldTheExtremesOfEveryTickOfARunAndTheIdleRigBesideIt) {
  Daemon daemon;
  daemon.start();
  Follower follower(daemon);
  ASSERT_TRUE(until(follower, [&] { return follower.idle_ >= 2; }));
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, experiment_text("followed", 0.8), false);
  ASSERT_TRUE(until(follower, [&] { return follower.is_running_; }));
  ASSERT_TRUE(until(follower, [&] { return !follower.is_running_; }));
  const std::size_t idle_before = follower.idle_;
  ASSERT_TRUE(until(follower, [&] { return follower.idle_ > idle_before + 1; })) << "the idle rig is shown again";
  EXPECT_EQ(follower.lost_, 0U);
  Range rod;
  Range volts;
  std::size_t ticks = 0;
  const fs::path folder = entry_of(daemon, entry).at("folder").get<std::string>();
  for (const acquisition::TickRecord& tick : record::read_ticks(folder)) {
    rod.add(tick.displacement_in);
    volts.add(tick.applied_V);
    ++ticks;
  }
  EXPECT_EQ(follower.of_runs_, (ticks + 39) / 40);
  EXPECT_EQ(follower.rod_.low, rod.low);
  EXPECT_EQ(follower.rod_.high, rod.high);
  EXPECT_EQ(follower.volts_.low, volts.low);
  EXPECT_EQ(follower.volts_.high, volts.high);
  // Tells a wrong origin of the times from a right one; the time itself is no promise of this test.
  EXPECT_GT(follower.oldest_s_, 0.0);
  EXPECT_LT(follower.oldest_s_, 60.0);
}

TEST(ServiceSamples, AreMissedByAReaderWhoIsTooSlowAndTheGapIsSaid) {
  Daemon daemon;
  daemon.start();
  // Once a second, while the service keeps 10 s.
  Follower follower(daemon, 1.0);
  follower.turn();
  Client client(daemon.socket());
  client.call("arm");
  // A minute and a half of the rig's time within some tenths of a second.
  submit(client, quiet_experiment_text("fast", 90.0));
  EXPECT_TRUE(until(follower, [&] { return follower.lost_ > 0; }));
}

/// The text between the first two fences after a heading of the manual page.
std::string listing_after(const std::string& page, const std::string& heading) {
  const std::string fence = "```\n";
  const std::size_t begin = page.find(fence, page.find(heading)) + fence.size();
  return page.substr(begin, page.find(fence, begin) - begin);
}

TEST(ServiceSamples, ReachThePythonClientOfTheManualPage) {
  if (output_of_shell("command -v python3").empty()) GTEST_SKIP() << "python3 is not installed";
  Daemon daemon;
  daemon.start();
  std::string script = listing_after(content_of(source_file("daemon/man/ehad-protocol.7.scd")), "# A CLIENT");
  EXPECT_LE(std::count(script.begin(), script.end(), '\n'), 15);
  const std::string usual = "/run/ehad/ehad.sock";
  ASSERT_NE(script.find(usual), std::string::npos) << script;
  script.replace(script.find(usual), usual.size(), daemon.socket().string());
  const fs::path file = daemon.folder() / "client.py";
  std::ofstream(file) << script;
  std::istringstream lines(output_of_shell("timeout 60 python3 '" + file.string() + "' 2>/dev/null | head -n 5"));
  std::uint64_t expected = 0;
  int read = 0;
  for (std::string line; std::getline(lines, line); ++read) {
    std::istringstream words(line);
    std::uint64_t number = 0;
    std::int64_t utc = 0;
    std::string run;
    double low = 0.0;
    double high = 0.0;
    ASSERT_TRUE(words >> number >> utc >> run >> low >> high) << line;
    EXPECT_TRUE(read == 0 || number == expected) << line << "; expected " << expected;
    EXPECT_EQ(run, "None") << line;
    EXPECT_LE(low, high) << line;
    expected = number + 1;
  }
  EXPECT_EQ(read, 5);
}

}  // namespace
}  // namespace eha::test
