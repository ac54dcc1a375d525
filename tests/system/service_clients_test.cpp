// SPDX-License-Identifier: GPL-3.0-or-later
// Two hundred misbehaving clients of six kinds during an experiment.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/control/line_buffer.hpp"
#include "daemon/control/socket_address.hpp"
#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using control::Client;

/// A plain connection whose calls never block.
class BareClient {
 public:
  explicit BareClient(const Daemon& daemon) {
    const sockaddr_un address = control::socket_address(daemon.socket());
    descriptor_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    connected_ = connect(descriptor_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    fcntl(descriptor_, F_SETFL, O_NONBLOCK);
  }
  BareClient(BareClient&& other) noexcept
      : descriptor_(std::exchange(other.descriptor_, -1)), connected_(other.connected_), lines_(other.lines_) {}
  BareClient(const BareClient&) = delete;
  BareClient& operator=(const BareClient&) = delete;
  ~BareClient() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  [[nodiscard]] bool is_connected() const { return connected_; }

  /// Sends as much as the socket takes now.
  void send(std::string_view bytes) {
    static_cast<void>(::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL));
  }

  /// Reads what has come. @returns whether the connection still stands
  bool read() {
    std::array<char, 65536> bytes;
    for (;;) {
      const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), 0);
      if (count < 0) return errno == EAGAIN;
      if (count == 0) return false;
      lines_.append({bytes.data(), static_cast<std::size_t>(count)});
    }
  }

  [[nodiscard]] std::optional<std::string> next_line() { return lines_.next_line(); }

 private:
  int descriptor_ = -1;
  bool connected_ = false;
  control::LineBuffer lines_{16 * 1024 * 1024};
};

/// Connects as another user while it lives, where the system allows that.
class AsUser {
 public:
  explicit AsUser(uid_t uid) : is_root_(geteuid() == 0) {
    if (is_root_) {
      EXPECT_EQ(seteuid(uid), 0);
    }
  }
  AsUser(const AsUser&) = delete;
  AsUser& operator=(const AsUser&) = delete;
  ~AsUser() {
    if (is_root_) {
      EXPECT_EQ(seteuid(0), 0);
    }
  }

 private:
  bool is_root_;
};

/// One that asks for the status and waits for each answer.
struct WellBehaved {
  BareClient connection;
  int asked = 0;
  int answered = 0;

  void turn() {
    if (asked == answered) connection.send(fmt::format("{{\"id\":{},\"method\":\"status\"}}\n", ++asked));
    connection.read();
    while (const auto line = connection.next_line()) {
      const Json answer = Json::parse(*line);
      if (answer.contains("ehad")) continue;  // the greeting
      if (answer.at("id") == answered + 1 && answer.contains("result")) ++answered;
    }
  }
};

std::string garbage(std::mt19937& random, std::size_t size) {
  std::uniform_int_distribution<int> byte(0, 255);
  std::string bytes(size, '\0');
  for (char& c : bytes) c = static_cast<char>(byte(random));
  return bytes;
}

std::int64_t resident_kB(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::stoll(line.substr(6));
  }
  return 0;
}

/// A quarter of an hour of the rig's time, some seconds of ours.
std::string long_experiment() { return quiet_experiment_text("clients", 900.0); }

Json play(const Daemon& daemon, Client& client, const std::function<void()>& meanwhile) {
  const std::int64_t entry = submit(client, long_experiment());
  return follow(daemon, entry, [&](const Json& snapshot) {
    meanwhile();
    return snapshot.at("entry").at("state") != "running" && snapshot.at("entry").at("state") != "waiting";
  });
}

TEST(ServiceClients, OfEveryBadKindLeaveNoTraceInTheRecord) {
  // Six kinds, 204 clients where they may be of several users, of whom each may have 64.
  const int of_each_kind = can_change_user() ? 34 : 10;
  Daemon daemon("schema = 1\n[worker]\nwall_time_s = 1\n");
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  const Json alone = play(daemon, client, [] {});
  ASSERT_EQ(alone.at("outcome"), "completed") << alone;
  const std::int64_t before_kB = resident_kB(daemon.pid());

  std::vector<WellBehaved> well_behaved;
  std::vector<BareClient> senders_of_garbage;
  std::vector<BareClient> senders_of_long_lines;
  std::vector<BareClient> senders_of_half_lines;
  std::vector<BareClient> readers_of_nothing;
  std::vector<BareClient> silent;
  daemon.open_to_all();
  for (int i = 0; i < of_each_kind; ++i) {
    const AsUser user(static_cast<uid_t>(1 + i % 4));
    well_behaved.push_back({BareClient(daemon)});
    senders_of_garbage.emplace_back(daemon);
    senders_of_long_lines.emplace_back(daemon);
    senders_of_half_lines.emplace_back(daemon);
    readers_of_nothing.emplace_back(daemon);
    silent.emplace_back(daemon);
    ASSERT_TRUE(silent.back().is_connected()) << i;
    senders_of_half_lines.back().send("{\"id\":1,\"method\":\"st");
    readers_of_nothing.back().send("{\"id\":1,\"method\":\"watch\",\"params\":{\"rate_Hz\":25}}\n");
  }
  std::mt19937 random(1);
  const std::string long_piece(60'000, 'x');
  int turns = 0;
  const Json beset = play(daemon, client, [&] {
    for (BareClient& sender : senders_of_garbage) {
      sender.send(garbage(random, 2000));
      sender.send("\n{\"id\":\"x\",\"method\":3}\n");
    }
    for (BareClient& sender : senders_of_long_lines) sender.send(long_piece);
    for (BareClient& reader : readers_of_nothing) reader.send("{\"id\":2,\"method\":\"queue\"}\n");
    for (WellBehaved& asker : well_behaved) asker.turn();
    ++turns;
  });
  ASSERT_EQ(beset.at("outcome"), "completed") << beset << daemon.log();
  EXPECT_GT(turns, 3) << "the experiment was over before the clients had begun";

  const fs::path one = alone.at("folder").get<std::string>();
  const fs::path other = beset.at("folder").get<std::string>();
  EXPECT_EQ(content_of(one / "raw.ehalog"), content_of(other / "raw.ehalog"));
  EXPECT_EQ(content_of(one / "raw.h5"), content_of(other / "raw.h5"));
  const Json counters = Json::parse(content_of(other / "run.json")).at("report").at("counters");
  EXPECT_EQ(counters.at("dropped"), 0);
  EXPECT_EQ(counters.at("skipped"), 0);

  // A client that keeps to the protocol gets every answer.
  for (WellBehaved& asker : well_behaved) {
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    const int wanted = std::max(asker.asked, 1);
    while (asker.answered < wanted && std::chrono::steady_clock::now() < deadline) asker.turn();
    EXPECT_GE(asker.answered, wanted);
  }
  // A line that is too long ends the connection, with a word of why.
  for (BareClient& sender : senders_of_long_lines) {
    std::string last;
    const auto deadline = std::chrono::steady_clock::now() + kGenerous;
    while (sender.read() && std::chrono::steady_clock::now() < deadline) sender.send(long_piece);
    while (const auto line = sender.next_line()) last = *line;
    EXPECT_NE(last.find("the connection is closed"), std::string::npos) << last;
  }
  const std::int64_t grown_kB = resident_kB(daemon.pid()) - before_kB;
  std::cout << "ehad grew by " << grown_kB << " kB at most, over " << turns << " turns of the clients\n";
#if !defined(__SANITIZE_ADDRESS__)  // which keeps what is freed for a while
  EXPECT_LT(grown_kB, 100 * 1024);
#endif
  EXPECT_EQ(client.call("status").at("lease").is_null(), false);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ServiceClients, ShareNoLockAndNoHeapWithTheLoop) {
  Daemon daemon;
  const fs::path report = daemon.folder() / "trap";
  daemon.set_environment(std::string("LD_PRELOAD=") + EHA_LOOP_TRAP_LIBRARY);
  daemon.set_environment("EHA_LOOP_TRAP=" + report.string());
  daemon.start();
  Client client(daemon.socket());
  client.call("arm");
  std::vector<BareClient> others;
  daemon.open_to_all();
  for (int i = 0; i < 100; ++i) {
    const AsUser user(static_cast<uid_t>(1 + i % 2));
    others.emplace_back(daemon);
  }
  std::mt19937 random(1);
  const std::int64_t entry = submit(client, quiet_experiment_text("trapped", 4.0), false);
  follow(daemon, entry, [&](const Json& snapshot) {
    for (BareClient& other : others) {
      other.send(garbage(random, 200));
      other.send("\n{\"id\":2,\"method\":\"status\"}\n");
      other.read();
    }
    return snapshot.at("entry").at("state") == "fitting";
  });
  long ticks = 0;
  long locks = -1;
  long allocations = -1;
  std::ifstream(report) >> ticks >> locks >> allocations;
  EXPECT_GE(ticks, 100) << "the trap saw no loop: " << daemon.log();
  EXPECT_EQ(locks, 0);
  EXPECT_EQ(allocations, 0);
}
#endif

TEST(ServiceClients, OfOneUserCloseNobodyElsesWatchAndKeepNobodyFromStopping) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  Daemon daemon;
  daemon.start();
  daemon.open_to_all();
  const auto bob = connect_as(1, daemon);
  bob->call("watch", {{"rate_Hz", 25}});
  std::string last;
  std::vector<BareClient> many;
  for (int i = 0; i < 400; ++i) {
    const AsUser user(65534);
    many.emplace_back(daemon);
    many.back().send("{\"id\":1,\"method\":\"watch\",\"params\":{\"rate_Hz\":0.01}}\n");
    ASSERT_TRUE(many.back().is_connected()) << i;
    // The greeting, and the answer.
    bool is_open = true;
    for (int lines = 0; lines < 2 && is_open;) {
      is_open = many.back().read();
      while (const auto line = many.back().next_line()) {
        last = *line;
        ++lines;
      }
    }
  }
  EXPECT_EQ(Client(daemon.socket()).call("status").at("state"), "faulted");
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(bob->next_event(kGenerous)) << "the watch of another user goes on";
  EXPECT_TRUE(many.front().read()) << "the oldest stays";
  EXPECT_FALSE(many.back().read());
  EXPECT_NE(last.find("nobody has 64 connections to ehad, the most that one user may have"), std::string::npos) << last;
  EXPECT_NE(refused(*connect_as(65534, daemon), "status").message.find("eha stop still works"), std::string::npos);
  EXPECT_EQ(connect_as(65534, daemon)->call("stop").at("stopped"), "nothing");
}

TEST(ServiceClients, ThatAreSilentMakeRoomForThoseWhoAsk) {
  Daemon daemon;
  daemon.start();
  std::vector<BareClient> silent;
  for (int i = 0; i < 400; ++i) {
    silent.emplace_back(daemon);
    ASSERT_TRUE(silent.back().is_connected()) << i;
  }
  Client client(daemon.socket());
  EXPECT_EQ(client.call("status").at("state"), "faulted");
}

}  // namespace
}  // namespace eha::test
