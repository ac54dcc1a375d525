// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/server.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <memory>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "daemon/control/client.hpp"
#include "daemon/control/socket_address.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::control {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

/// A server that answers `status` at once and leaves every other request open; driven by hand.
class ServerTest : public ::testing::Test {
 protected:
  ServerTest() { open({}); }

  void open(ServerLimits limits) {
    server_ = nullptr;
    server_ = std::make_unique<Server>(
        loop_, path_, limits,
        [this](const Peer& peer, const Request& request) {
          requests_.push_back(request.method);
          peer_ = peer;
          if (request.method == "status") server_->respond(peer.client, request.id, {{"state", "idle"}});
        },
        [this](ClientId) { ++gone_; }, [](uid_t uid) { return std::to_string(uid); });
  }

  int connect_raw() {
    const sockaddr_un address = socket_address(path_);
    const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    EXPECT_EQ(connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    fcntl(descriptor, F_SETFL, O_NONBLOCK);
    turn();
    return descriptor;
  }

  /// Serves until nothing is ready any more.
  void turn() {
    for (int i = 0; i < 50; ++i) loop_.run_once(0ms);
  }

  static void say(int descriptor, const std::string& text) {
    EXPECT_EQ(::send(descriptor, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
  }

  /// The text that can be read; ends with "<end>" when the connection is closed.
  static std::string hear(int descriptor) {
    std::string text;
    std::array<char, 4096> bytes;
    for (;;) {
      const ssize_t count = recv(descriptor, bytes.data(), bytes.size(), 0);
      if (count < 0 && errno == EAGAIN) return text;
      if (count <= 0) return text + "<end>";
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
  }

  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "s";
  EventLoop loop_;
  std::unique_ptr<Server> server_;
  std::vector<std::string> requests_;
  Peer peer_;
  int gone_ = 0;
};

TEST_F(ServerTest, IsForItsOwnerAndItsGroupOnly) {
  struct stat facts {};
  ASSERT_EQ(stat(path_.c_str(), &facts), 0);
  EXPECT_EQ(facts.st_mode & 0777U, 0660U);
}

TEST_F(ServerTest, GreetsAnswersAndKnowsWhoAsks) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"status\"}\n");
  turn();
  EXPECT_EQ(hear(client), greeting_line() + "{\"id\":1,\"result\":{\"state\":\"idle\"}}\n");
  EXPECT_EQ(peer_.uid, geteuid());
  EXPECT_EQ(peer_.pid, getpid());
  close(client);
  turn();
  EXPECT_EQ(gone_, 1);
  EXPECT_EQ(server_->clients(), 0U);
}

TEST_F(ServerTest, DoesNotReadTheNextRequestBeforeTheOneBeforeIsAnswered) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"arm\"}\n{\"id\":2,\"method\":\"status\"}\n");
  turn();
  EXPECT_EQ(requests_, std::vector<std::string>{"arm"});
  server_->respond(peer_.client, 1, {{"state", "armed"}});
  turn();
  EXPECT_EQ(requests_, (std::vector<std::string>{"arm", "status"}));
  EXPECT_EQ(hear(client), greeting_line() +
                              "{\"id\":1,\"result\":{\"state\":\"armed\"}}\n"
                              "{\"id\":2,\"result\":{\"state\":\"idle\"}}\n");
  close(client);
}

TEST_F(ServerTest, AnswersAnotherOneBesideAClientWithManyRequestsAtOnce) {
  const int many = connect_raw();
  const int one = connect_raw();
  static_cast<void>(hear(many));
  static_cast<void>(hear(one));
  std::string requests;
  for (int i = 0; i < 400; ++i) requests += "{\"id\":1,\"method\":\"status\"}\n";
  say(many, requests);
  say(one, "{\"id\":2,\"method\":\"status\"}\n");
  loop_.run_once(0ms);
  EXPECT_EQ(hear(one), "{\"id\":2,\"result\":{\"state\":\"idle\"}}\n");
  EXPECT_LT(requests_.size(), 20U) << "of many a few at a time";
  shutdown(many, SHUT_WR);
  std::string answers;
  for (int i = 0; i < 50 && !answers.ends_with("<end>"); ++i) {
    turn();
    answers += hear(many);
  }
  EXPECT_EQ(requests_.size(), 401U) << "and in the end all";
  EXPECT_TRUE(answers.ends_with("<end>")) << answers;
  EXPECT_EQ(std::count(answers.begin(), answers.end(), '\n'), 400);
  close(one);
}

TEST_F(ServerTest, AnswersWhoHasClosedItsOwnHalf) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"arm\"}\n");
  shutdown(client, SHUT_WR);
  turn();
  server_->respond(peer_.client, 1, {{"state", "armed"}});
  turn();
  EXPECT_EQ(hear(client), greeting_line() + "{\"id\":1,\"result\":{\"state\":\"armed\"}}\n<end>");
  close(client);
}

TEST_F(ServerTest, AnswersNobodyWhenTheAskerHasGone) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"arm\"}\n");
  turn();
  close(client);
  turn();
  EXPECT_EQ(server_->clients(), 0U);
  server_->respond(peer_.client, 1, Json());
}

TEST_F(ServerTest, ClosesAfterALineThatIsTooLongAndSaysWhy) {
  const int client = connect_raw();
  const std::string piece(64 * 1024, 'x');
  for (int i = 0; i < 5; ++i) {
    static_cast<void>(::send(client, piece.data(), piece.size(), MSG_NOSIGNAL));
    turn();
  }
  const std::string heard = hear(client);
  EXPECT_NE(heard.find("at most 262144 bytes"), std::string::npos) << heard;
  EXPECT_TRUE(heard.ends_with("<end>"));
  close(client);
}

TEST_F(ServerTest, DropsThoseWhoAreSilentForTooLongAndNoOthers) {
  const int silent = connect_raw();
  const int half = connect_raw();
  const int good = connect_raw();
  say(half, "{\"id\":1,\"method\":\"status\"}\n{\"id\":2,");
  say(good, "{\"id\":1,\"method\":\"status\"}\n");
  turn();
  server_->sweep(steady_clock::now() + 29s);
  EXPECT_EQ(server_->clients(), 3U);
  server_->sweep(steady_clock::now() + 31s);
  EXPECT_EQ(server_->clients(), 1U);
  EXPECT_TRUE(hear(silent).ends_with("<end>"));
  EXPECT_TRUE(hear(half).ends_with("<end>"));
  EXPECT_FALSE(hear(good).ends_with("<end>"));
  for (const int descriptor : {silent, half, good}) close(descriptor);
}

TEST_F(ServerTest, LeavesOutWhatASlowReaderDoesNotTakeAndDropsHimInTheEnd) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"status\"}\n");
  turn();
  const std::string line(10'000, 'x');
  // The kernel's buffer fills; further lines are left out, not kept.
  for (int i = 0; i < 1000; ++i) server_->stream(peer_.client, line + "\n", Delivery::when_read);
  turn();
  EXPECT_EQ(server_->clients(), 1U);
  server_->sweep(steady_clock::now() + 31s);
  EXPECT_EQ(server_->clients(), 0U);
  EXPECT_LT(hear(client).size(), 1000U * line.size());
  close(client);
}

TEST_F(ServerTest, DropsAReaderWhoLetsTooMuchPileUp) {
  const int client = connect_raw();
  say(client, "{\"id\":1,\"method\":\"status\"}\n");
  turn();
  const std::string line(10'000, 'x');
  for (int i = 0; i < 1000; ++i) server_->stream(peer_.client, line + "\n", Delivery::always);
  turn();
  server_->sweep(steady_clock::now());
  EXPECT_EQ(server_->clients(), 0U);
  close(client);
}

TEST_F(ServerTest, MakesRoomForANewClientByDroppingTheIdlest) {
  open({.clients = 2, .unread_bytes = 1024, .silence = 30s});
  const int asker = connect_raw();
  say(asker, "{\"id\":1,\"method\":\"status\"}\n");
  turn();
  const int silent = connect_raw();
  const int late = connect_raw();
  EXPECT_EQ(server_->clients(), 2U);
  EXPECT_TRUE(hear(silent).ends_with("<end>"));
  EXPECT_FALSE(hear(asker).ends_with("<end>"));
  EXPECT_EQ(hear(late), greeting_line());
  for (const int descriptor : {asker, silent, late}) close(descriptor);
}

TEST_F(ServerTest, RefusesTheNewestOfAUserWithTooManyButNoStop) {
  open({.clients = 256, .clients_of_user = 2, .spare_of_user = 1});
  const int first = connect_raw();
  const int second = connect_raw();
  for (const int descriptor : {first, second}) {
    say(descriptor, "{\"id\":1,\"method\":\"status\"}\n");
    turn();
    EXPECT_TRUE(hear(descriptor).ends_with("{\"id\":1,\"result\":{\"state\":\"idle\"}}\n"));
  }
  const int asker = connect_raw();
  say(asker, "{\"id\":7,\"method\":\"status\"}\n");
  turn();
  const std::string refused = hear(asker);
  EXPECT_NE(refused.find("{\"id\":7,\"error\":{\"code\":69,"), std::string::npos) << refused;
  EXPECT_NE(refused.find("has 2 connections to ehad, the most"), std::string::npos) << refused;
  EXPECT_TRUE(refused.ends_with("<end>")) << refused;
  // The spare connection is there for a stop, also when somebody has taken it and says nothing.
  const int silent = connect_raw();
  const int stopper = connect_raw();
  EXPECT_TRUE(hear(silent).ends_with("<end>"));
  say(stopper, "{\"id\":1,\"method\":\"stop\"}\n");
  turn();
  EXPECT_EQ(requests_.back(), "stop");
  server_->respond(peer_.client, 1, {{"stopped", "nothing"}});
  turn();
  const std::string stopped = hear(stopper);
  EXPECT_NE(stopped.find("{\"id\":1,\"result\":{\"stopped\":\"nothing\"}}"), std::string::npos) << stopped;
  EXPECT_TRUE(stopped.ends_with("<end>")) << stopped;
  EXPECT_EQ(server_->clients(), 2U);
  EXPECT_EQ(hear(first), "") << "it stays";
  for (const int descriptor : {first, second, asker, silent, stopper}) close(descriptor);
}

TEST_F(ServerTest, AnswersWithinAStormOfConnections) {
  const int client = connect_raw();
  static_cast<void>(hear(client));
  std::vector<os::FileDescriptor> storm;
  const sockaddr_un address = socket_address(path_);
  for (int i = 0; i < 50; ++i) {
    storm.emplace_back(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
    ASSERT_EQ(connect(storm.back().get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << i;
  }
  say(client, "{\"id\":1,\"method\":\"status\"}\n");
  loop_.run_once(0ms);
  EXPECT_NE(hear(client).find("\"idle\""), std::string::npos);
  EXPECT_LT(server_->clients(), 51U) << "the storm is not awaited";
  turn();
  EXPECT_EQ(server_->clients(), 51U);
  close(client);
}

TEST_F(ServerTest, TakesThePlaceOfADeadOneAndOfNoLiveOne) {
  EXPECT_THROW(Server(
                   loop_, path_, {}, [](const Peer&, const Request&) {}, [](ClientId) {}, [](uid_t) { return ""; }),
               DeviceError);
  server_ = nullptr;
  // As SIGKILL leaves it.
  const int dead = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = socket_address(path_);
  ASSERT_EQ(bind(dead, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  close(dead);
  open({});
  EXPECT_EQ(hear(connect_raw()), greeting_line());
}

TEST(ClientOfTheService, SaysWhatIsWrongWithTheSocket) {
  const test::TemporaryFolder folder;
  try {
    const Client client(folder.path() / "none");
    ADD_FAILURE();
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("ehad is not running"), std::string::npos);
  }
  EXPECT_THROW(Client(std::string(200, 'x')), ConfigError);
}

}  // namespace
}  // namespace eha::control
