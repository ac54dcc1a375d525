// SPDX-License-Identifier: GPL-3.0-or-later
// Clients that a browser is not: slow, endless, too many.
#include "daemon/web/web_server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/error.hpp"
#include "core/os/file_descriptor.hpp"
#include "daemon/web/connection_owner.hpp"
#include "tests/unit/other_users.hpp"

namespace eha::web {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

constexpr auto kGenerous = 60s;

/// A connection that sends and reads what it likes.
class RawClient {
 public:
  explicit RawClient(std::uint16_t port, int receive_bytes = 0, int family = AF_INET)
      : descriptor_(socket(family, SOCK_STREAM, 0)) {
    if (receive_bytes > 0) setsockopt(descriptor_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    v6.sin6_addr = in6addr_loopback;
    const auto* address =
        family == AF_INET ? reinterpret_cast<const sockaddr*>(&v4) : reinterpret_cast<const sockaddr*>(&v6);
    if (connect(descriptor_, address, family == AF_INET ? sizeof v4 : sizeof v6) != 0) {
      throw std::runtime_error("cannot connect");
    }
  }
  RawClient(RawClient&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  RawClient(const RawClient&) = delete;
  ~RawClient() {
    if (descriptor_ >= 0) close(descriptor_);
  }

  bool say(const std::string& text) const {
    return send(descriptor_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }

  /// What comes until the other side closes; "<silence>" at the end when it does not.
  [[nodiscard]] std::string hear(std::chrono::milliseconds patience = kGenerous) const {
    std::string text;
    std::array<char, 4096> bytes{};
    for (;;) {
      pollfd waiting{.fd = descriptor_, .events = POLLIN, .revents = 0};
      if (poll(&waiting, 1, static_cast<int>(patience.count())) <= 0) return text + "<silence>";
      const ssize_t count = recv(descriptor_, bytes.data(), bytes.size(), 0);
      if (count <= 0) return text;
      text.append(bytes.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  int descriptor_;
};

class WebServerTest : public ::testing::Test {
 protected:
  void start(const StreamLimits& limits = {}) {
    server_.emplace(Listeners::on_port(0), limits,
                    [this](const httplib::Request& request, httplib::Response& response, uid_t user) {
                      {
                        const std::lock_guard lock(mutex_);
                        users_.insert(user);
                      }
                      if (request.path == "/broken") throw std::runtime_error("broken");
                      if (request.path == "/long") {
                        response.set_content(std::string(64u << 20, 'x'), "text/plain");
                      } else if (request.path == "/token") {
                        response.set_content("<" + request.get_header_value("X-Eha-Token") + ">", "text/plain");
                      } else {
                        response.set_content(request.method + " " + request.body, "text/plain");
                      }
                    });
    served_ = std::async(std::launch::async, [this] { server_->serve(AccessRules(server_->port(), {})); });
  }

  void TearDown() override {
    if (!server_) return;
    server_->end();
    served_.get();
  }

  [[nodiscard]] std::string head(const std::string& line = "GET / HTTP/1.1") const {
    return line + "\r\nHost: 127.0.0.1:" + std::to_string(server_->port()) + "\r\n";
  }
  [[nodiscard]] RawClient connected() const { return RawClient(server_->port()); }

  [[nodiscard]] std::string post(const std::string& path = "/") const {
    return head("POST " + path + " HTTP/1.1") + "Origin: http://127.0.0.1:" + std::to_string(server_->port()) +
           "\r\nContent-Length: 0\r\n\r\n";
  }
  [[nodiscard]] bool has_connections(std::size_t count) const {
    const auto deadline = steady_clock::now() + kGenerous;
    while (server_->connections() != count && steady_clock::now() < deadline) std::this_thread::sleep_for(1ms);
    return server_->connections() == count;
  }

  std::mutex mutex_;
  std::set<uid_t> users_;  ///< whose requests were answered
  std::optional<WebServer> server_;
  std::future<void> served_;
};

/// Whether sockets can be those of another user; while it lives they are.
class OtherUser {
 public:
  OtherUser() : is_other_(geteuid() == 0 && seteuid(test::kOtherUser) == 0) {}
  OtherUser(const OtherUser&) = delete;
  ~OtherUser() {
    if (is_other_ && seteuid(0) != 0) std::abort();
  }
  explicit operator bool() const { return is_other_; }

 private:
  bool is_other_;
};

TEST_F(WebServerTest, AnswersOneRequestAfterTheOther) {
  start();
  const RawClient client = connected();
  ASSERT_TRUE(client.say(head() + "\r\n" + head("GET / HTTP/1.1") + "Connection: close\r\n\r\n"));
  const std::string answers = client.hear();
  std::size_t found = 0;
  for (std::size_t at = answers.find("200 OK"); at != std::string::npos; at = answers.find("200 OK", at + 1)) ++found;
  EXPECT_EQ(found, 2U) << answers;
  for (const char* header : {"X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer",
                             "Content-Security-Policy: default-src 'none'", "Cache-Control: no-store"}) {
    EXPECT_NE(answers.find(header), std::string::npos) << header;
  }
}

TEST_F(WebServerTest, HandsOverTheBodyOfAPostAndClosesThen) {
  start();
  const RawClient client = connected();
  const std::string origin = "Origin: http://127.0.0.1:" + std::to_string(server_->port()) + "\r\n";
  ASSERT_TRUE(client.say(head("POST / HTTP/1.1") + origin + "Content-Length: 4\r\n\r\nbody"));
  const std::string answer = client.hear();
  EXPECT_NE(answer.find("POST body"), std::string::npos) << answer;
  EXPECT_NE(answer.find("Connection: close"), std::string::npos) << answer;
}

TEST_F(WebServerTest, HandsOverHeadersAsTheyWereSent) {
  start();
  const RawClient client = connected();
  for (const char* token : {"%41bc", "a%0d%0aHost: b", "abc", "%"}) {
    ASSERT_TRUE(client.say(head("GET /token HTTP/1.1") + "x-eha-token: \t" + token + " \r\n\r\n"));
  }
  ASSERT_TRUE(client.say(head("GET /token HTTP/1.1") + "Connection: close\r\n\r\n"));
  const std::string answers = client.hear();
  for (const char* token : {"<%41bc>", "<a%0d%0aHost: b>", "<abc>", "<%>", "<>"}) {
    EXPECT_NE(answers.find(token), std::string::npos) << token << '\n' << answers;
  }
}

TEST_F(WebServerTest, WaitsForNoBodyWhoseLengthIsNotSaid) {
  // Longer than anybody here waits: only an answer at once passes.
  start({.idle = 600s, .request = 600s});
  const RawClient client = connected();
  const std::string origin = "Origin: http://127.0.0.1:" + std::to_string(server_->port()) + "\r\n";
  ASSERT_TRUE(client.say(head("POST / HTTP/1.1") + origin + "\r\n"));
  const std::string answer = client.hear();
  EXPECT_EQ(answer.rfind("HTTP/1.1 411", 0), 0U) << answer;
  EXPECT_NE(answer.find("Connection: close"), std::string::npos) << answer;
}

TEST_F(WebServerTest, ReadsNoBodyOfARefusedPost) {
  start();
  const RawClient client = connected();
  ASSERT_TRUE(client.say(head("POST / HTTP/1.1") + "Content-Length: 30\r\n\r\nGET / HTTP/1.1\r\n"));
  const std::string answer = client.hear();
  EXPECT_NE(answer.find("403"), std::string::npos) << answer;
  EXPECT_EQ(answer.find("200 OK"), std::string::npos) << "the body is no request";
}

TEST_F(WebServerTest, RefusesABodyThatIsTooLong) {
  start();
  const RawClient client = connected();
  const std::string origin = "Origin: http://127.0.0.1:" + std::to_string(server_->port()) + "\r\n";
  client.say(head("POST / HTTP/1.1") + origin + "Content-Length: 5000\r\n\r\n" + std::string(5000, 'x'));
  EXPECT_NE(client.hear().find("413"), std::string::npos);
}

TEST_F(WebServerTest, RefusesAMegabyteOfHeaders) {
  start();
  for (const std::string& piece : {std::string(1u << 20, 'x'), std::string(100'000, 'x')}) {
    const RawClient client = connected();
    client.say(head() + "X: " + piece + "\r\n\r\n");
    EXPECT_NE(client.hear().find("431"), std::string::npos);
  }
  const RawClient many = connected();
  std::string headers = head();
  for (int i = 0; i < 20'000; ++i) headers += "A" + std::to_string(i) + ": b\r\n";
  many.say(headers + "\r\n");
  EXPECT_NE(many.hear().find("431"), std::string::npos);
}

TEST_F(WebServerTest, AnswersGarbageWithARefusal) {
  start({.idle = 60s, .request = 100ms});
  for (const std::string& text :
       {std::string("\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("\x16\x03\x01\x02\n\n"),
        std::string(100, '\0') + "\r\n\r\n", std::string("GET / HTTP/9.9\r\n\r\n")}) {
    const RawClient client = connected();
    client.say(text);
    const std::string answer = client.hear();
    EXPECT_TRUE(answer.find(" 400 ") != std::string::npos || answer.empty()) << answer;
  }
}

TEST_F(WebServerTest, CutsARequestThatComesSlowlyByteByByte) {
  start({.idle = 60s, .request = 200ms});
  const RawClient client = connected();
  const auto begun = steady_clock::now();
  std::thread slow([&] {
    while (client.say("G") && steady_clock::now() - begun < kGenerous) std::this_thread::sleep_for(10ms);
  });
  const std::string answer = client.hear();
  EXPECT_EQ(answer.find("<silence>"), std::string::npos) << answer;
  slow.join();
  EXPECT_LT(steady_clock::now() - begun, kGenerous);
}

TEST_F(WebServerTest, CutsAConnectionOnWhichNothingIsAsked) {
  start({.idle = 100ms});
  const RawClient client = connected();
  EXPECT_EQ(client.hear(), "");
}

TEST_F(WebServerTest, CutsAClientThatDoesNotTakeItsAnswer) {
  start({.answer = 200ms});
  const RawClient client(server_->port(), 4096);
  ASSERT_TRUE(client.say(head("GET /long HTTP/1.1") + "\r\n"));
  const auto deadline = steady_clock::now() + kGenerous;
  while (server_->connections() != 1 && steady_clock::now() < deadline) std::this_thread::sleep_for(1ms);
  while (server_->connections() != 0 && steady_clock::now() < deadline) std::this_thread::sleep_for(5ms);
  EXPECT_EQ(server_->connections(), 0U);
  EXPECT_LT(client.hear().size(), 64u << 20);
}

TEST_F(WebServerTest, RefusesAConnectionTooManyAndServesAgainWhenOneIsGone) {
  start({.idle = 60s});
  std::vector<RawClient> clients;
  for (std::size_t i = 0; i < Seats::kOfOneUser; ++i) clients.push_back(connected());
  ASSERT_TRUE(has_connections(Seats::kOfOneUser));
  // A spare seat: only a POST is answered, and nobody waits for it for long.
  const RawClient spare = connected();
  ASSERT_TRUE(spare.say(post()));
  EXPECT_EQ(spare.hear().rfind("HTTP/1.1 200", 0), 0U);
  ASSERT_TRUE(has_connections(Seats::kOfOneUser));
  const RawClient asking = connected();
  ASSERT_TRUE(asking.say(head() + "\r\n"));
  EXPECT_EQ(asking.hear().rfind("HTTP/1.1 503", 0), 0U);
  const RawClient silent = connected();
  EXPECT_EQ(silent.hear(), "");
  ASSERT_TRUE(clients.back().say(head() + "Connection: close\r\n\r\n")) << "those that are connected are served";
  EXPECT_NE(clients.back().hear().find("200 OK"), std::string::npos);
  clients.clear();
  ASSERT_TRUE(has_connections(0));
  const RawClient late = connected();
  ASSERT_TRUE(late.say(head() + "Connection: close\r\n\r\n"));
  EXPECT_NE(late.hear().find("200 OK"), std::string::npos);
}

TEST_F(WebServerTest, AnswersAStopWhileAnotherUserHoldsAllThatHeMay) {
  start({.idle = 60s, .request = 60s});
  std::vector<RawClient> held;
  {
    const OtherUser other;
    if (!other) GTEST_SKIP() << "needs root, to act as two users";
    for (int i = 0; i < 300; ++i) held.push_back(connected());
    for (const RawClient& client : held) client.say("POST / HTTP/1.1\r\n");
  }
  for (int i = 0; i < 40; ++i) {
    const auto begun = steady_clock::now();
    const RawClient client = connected();
    ASSERT_TRUE(client.say(post()));
    EXPECT_EQ(client.hear().rfind("HTTP/1.1 200", 0), 0U) << i;
    EXPECT_LT(steady_clock::now() - begun, 500ms) << "a stop takes that long";
  }
}

/// Opens connections as another user, one after the other, each with a part of a request, and keeps the last 200, until
/// `at_least` are made and the pipe `goes_on` has ended. For a process of its own: only system calls.
/// @returns whether all were opened
bool storm(std::uint16_t port, int at_least, int goes_on) noexcept {
  std::array<int, 200> kept{};
  kept.fill(-1);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  pollfd end{.fd = goes_on, .events = POLLIN, .revents = 0};
  for (int i = 0; i < at_least || poll(&end, 1, 0) == 0; ++i) {
    int& descriptor = kept[static_cast<std::size_t>(i) % kept.size()];
    if (descriptor >= 0) close(descriptor);
    descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return false;
    static constexpr std::string_view kPart = "POST / HTTP/1.1\r\n";
    static_cast<void>(send(descriptor, kPart.data(), kPart.size(), MSG_NOSIGNAL));
  }
  return true;
}

TEST_F(WebServerTest, AnswersEveryStopDuringTenThousandConnectionsOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to act as two users";
  const test::BeforeOthers before_others;
  start({.idle = 60s, .request = 60s});
  constexpr int kConnections = 10'000;
  constexpr int kProcesses = 4;
  constexpr std::size_t kStops = 20;
  const std::uint16_t port = server_->port();
  test::OtherUsersStorm storms(kProcesses,
                               [&](int goes_on) { return storm(port, kConnections / kProcesses, goes_on); });
  std::vector<double> took_ms;
  while (storms.goes_on()) {
    const auto begun = steady_clock::now();
    const RawClient client = connected();
    EXPECT_TRUE(client.say(post()));
    EXPECT_EQ(client.hear().rfind("HTTP/1.1 200", 0), 0U) << took_ms.size();
    took_ms.push_back(std::chrono::duration<double, std::milli>(steady_clock::now() - begun).count());
    if (took_ms.size() == kStops) storms.let_end();
  }
  EXPECT_TRUE(storms.all_could()) << "not all connections were made";
  ASSERT_GE(took_ms.size(), kStops);
  // A stop waits its turn behind those in the accept queue, at most 4096; each costs some 20 us of a processor.
  const double slowest_ms = *std::max_element(took_ms.begin(), took_ms.end());
  std::printf("%zu stops during the storm, the slowest %.1f ms\n", took_ms.size(), slowest_ms);
  EXPECT_LT(slowest_ms, 500.0);
}

TEST_F(WebServerTest, BlamesTheUserOfAConnectionThatIsClosedAtOnce) {
  start();
  {
    const OtherUser other;
    if (!other) GTEST_SKIP() << "needs root, to act as two users";
    for (int i = 0; i < 2000; ++i) {
      const RawClient client = connected();
      client.say(post());
    }
  }
  // What was accepted before this one has been admitted by then.
  const RawClient last = connected();
  ASSERT_TRUE(last.say(post("/broken")));
  EXPECT_EQ(last.hear().rfind("HTTP/1.1 500", 0), 0U);
  ASSERT_TRUE(has_connections(0));
  const std::lock_guard lock(mutex_);
  users_.erase(test::kOtherUser);
  EXPECT_EQ(users_, std::set<uid_t>{0}) << "of the last one alone";
}

TEST_F(WebServerTest, IsAtBothLoopbackAddresses) {
  start();
  for (const int family : {AF_INET, AF_INET6}) {
    const RawClient client(server_->port(), 0, family);
    ASSERT_TRUE(client.say(head() + "Connection: close\r\n\r\n"));
    EXPECT_NE(client.hear().find("200 OK"), std::string::npos) << family;
  }
  const std::lock_guard lock(mutex_);
  EXPECT_EQ(users_, std::set<uid_t>{geteuid()});
}

TEST_F(WebServerTest, EndsBeforeItServes) {
  WebServer server(Listeners::on_port(0), {}, [](const httplib::Request&, httplib::Response&, uid_t) {});
  server.end();
  server.serve(AccessRules(server.port(), {}));
  EXPECT_EQ(server.connections(), 0U);
}

TEST_F(WebServerTest, AnswersAnExceptionWithItsMessage) {
  start();
  const RawClient client = connected();
  ASSERT_TRUE(client.say(head("GET /broken HTTP/1.1") + "Connection: close\r\n\r\n"));
  const std::string answer = client.hear();
  EXPECT_NE(answer.find("500"), std::string::npos) << answer;
  EXPECT_NE(answer.find(R"({"error":"broken"})"), std::string::npos) << answer;
}

TEST(Listeners, SayThatThePortIsTakenOnEitherAddress) {
  for (const int family : {AF_INET, AF_INET6}) {
    const Listeners first = Listeners::on_port(0);
    const os::FileDescriptor other(socket(family, SOCK_STREAM, 0));
    sockaddr_in v4{};
    v4.sin_family = AF_INET;
    v4.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sockaddr_in6 v6{};
    v6.sin6_family = AF_INET6;
    v6.sin6_addr = in6addr_loopback;
    auto* address = family == AF_INET ? reinterpret_cast<sockaddr*>(&v4) : reinterpret_cast<sockaddr*>(&v6);
    socklen_t size = family == AF_INET ? sizeof v4 : sizeof v6;
    ASSERT_EQ(bind(other.get(), address, size), 0);
    ASSERT_EQ(listen(other.get(), 1), 0);
    ASSERT_EQ(getsockname(other.get(), address, &size), 0);
    for (const std::uint16_t port : {first.port(), ntohs(family == AF_INET ? v4.sin_port : v6.sin6_port)}) {
      try {
        static_cast<void>(Listeners::on_port(port));
        ADD_FAILURE() << "two processes at one port";
      } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find("--port"), std::string::npos) << error.what();
      }
    }
  }
}

TEST(Listeners, AreTakenOverFromTheServiceManager) {
  // In a process of its own, because the numbers of the descriptors are fixed.
  EXPECT_EXIT(
      {
        const Listeners opened = Listeners::on_port(0);
        int next = 3;
        for (const os::FileDescriptor& socket : opened.sockets()) {
          if (socket.get() != next) dup2(socket.get(), next);
          ++next;
        }
        setenv("LISTEN_PID", std::to_string(getpid()).c_str(), 1);
        setenv("LISTEN_FDS", std::to_string(opened.sockets().size()).c_str(), 1);
        const Listeners taken = Listeners::inherited();
        std::_Exit(taken.port() == opened.port() && taken.sockets().size() == opened.sockets().size() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

TEST(ConnectionOwner, IsFoundInTheKernelsTableToo) {
  const Listeners listeners = Listeners::on_port(0);
  for (std::size_t i = 0; i < listeners.sockets().size(); ++i) {
    auto client = std::make_optional<RawClient>(listeners.port(), 0, i == 0 ? AF_INET : AF_INET6);
    pollfd waiting{.fd = listeners.sockets()[i].get(), .events = POLLIN, .revents = 0};
    ASSERT_EQ(poll(&waiting, 1, 60'000), 1);
    const os::FileDescriptor accepted(accept(listeners.sockets()[i].get(), nullptr, nullptr));
    ASSERT_TRUE(accepted);
    EXPECT_EQ(connection_owner(accepted.get()), geteuid());
    EXPECT_EQ(detail::connection_owner_in_table(accepted.get()), geteuid());
    client.reset();
    EXPECT_EQ(connection_owner(accepted.get()), std::nullopt);
    EXPECT_EQ(detail::connection_owner_in_table(accepted.get()), std::nullopt);
  }
}

}  // namespace
}  // namespace eha::web
