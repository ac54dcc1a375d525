// SPDX-License-Identifier: GPL-3.0-or-later
// eha-web beside a live service, over HTTP.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/system/daemon.hpp"
#include "tests/system/program.hpp"
#include "tests/unit/other_users.hpp"

namespace eha::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using control::Client;
using std::chrono::steady_clock;

bool wait_until(const std::function<bool()>& done) {
  const auto deadline = steady_clock::now() + kGenerous;
  while (!done()) {
    if (steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

/// A running eha-web on a free port.
class Page {
 public:
  explicit Page(const Daemon& daemon, std::vector<std::string> options = {})
      : output_(daemon.folder() / "web.out"), log_(daemon.folder() / "web.log") {
    fs::remove(output_);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log_.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    std::vector<std::string> words{EHA_PROGRAM, "web", "--port", "0", "--socket", daemon.socket().string()};
    words.insert(words.end(), options.begin(), options.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = posix_spawn(&pid_, EHA_PROGRAM, &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("cannot start eha web");
    const bool has_token = options.empty();
    std::smatch found;
    std::string said;
    const std::regex printed(has_token ? "http://127.0.0.1:([0-9]+)\n.*: ([0-9a-f]{32})\n"
                                       : "http://127.0.0.1:([0-9]+)\n");
    if (!wait_until([&] {
          if (fs::exists(output_)) said = content_of(output_);
          return std::regex_search(said, found, printed) || waitpid(pid_, nullptr, WNOHANG) == pid_;
        }) ||
        found.empty()) {
      throw std::runtime_error("eha web does not serve: " + content_of(log_));
    }
    port_ = std::stoi(found[1]);
    if (has_token) token_ = found[2];
  }
  Page(const Page&) = delete;
  ~Page() {
    if (pid_ > 0) end();
  }

  /// @returns the exit code
  int end() {
    kill(pid_, SIGTERM);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  [[nodiscard]] httplib::Result get(const std::string& path, const httplib::Headers& headers = {}) const {
    return client().Get(path, headers);
  }
  /// The JSON under a path, which must be there.
  [[nodiscard]] Json json(const std::string& path) const {
    const httplib::Result answer = get(path);
    if (!answer) throw std::runtime_error("no answer: " + content_of(log_));
    EXPECT_EQ(answer->status, 200) << path << answer->body;
    EXPECT_EQ(answer->get_header_value("Content-Type"), "application/json") << path;
    return Json::parse(answer->body);
  }
  [[nodiscard]] int status_of(const std::string& path, const httplib::Headers& headers = {}) const {
    const httplib::Result answer = get(path, headers);
    return answer ? answer->status : 0;
  }
  /// @param headers  beside a right origin; one of the same name replaces it
  [[nodiscard]] httplib::Result stop(httplib::Headers headers) const { return post("/api/stop", std::move(headers)); }
  [[nodiscard]] httplib::Result post(const std::string& path, httplib::Headers headers) const {
    if (headers.count("Origin") == 0) headers.emplace("Origin", "http://127.0.0.1:" + std::to_string(port_));
    return client().Post(path, headers, "{}", "application/json");
  }
  [[nodiscard]] const std::string& token() const noexcept { return token_; }
  [[nodiscard]] int port() const noexcept { return port_; }
  [[nodiscard]] std::string log() const { return content_of(log_); }

 private:
  [[nodiscard]] httplib::Client client() const {
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(60);
    client.set_url_encode(false);
    return client;
  }

  fs::path output_;
  fs::path log_;
  pid_t pid_ = -1;
  int port_ = 0;
  std::string token_;
};

std::string connection(const Page& page) { return page.json("/api/state").at("daemon"); }

TEST(Web, ShowsTheRigTheQueueAndTheFilesOfARun) {
  Daemon daemon;
  daemon.start();
  Page page(daemon);
  ASSERT_TRUE(wait_until([&] { return connection(page) == "connected"; }));
  EXPECT_TRUE(page.json("/api/response").at("run").is_null());
  EXPECT_TRUE(page.json("/api/runs?limit=5").empty());
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, experiment_text("shown", 4.0));
  const Json followed =
      follow(daemon, entry, [](const Json& snapshot) { return snapshot.at("entry").at("state") == "fitting"; });
  const std::string id = followed.at("run");

  ASSERT_TRUE(wait_until([&] { return !page.json("/api/state").at("queue").empty(); }));
  const Json state = page.json("/api/state");
  EXPECT_EQ(state.at("status").at("rig").at("backend"), "sim");
  EXPECT_EQ(state.at("units"), "in");
  EXPECT_EQ(state.at("limits").at("travel_max_in"), 5.75);
  EXPECT_EQ(state.at("limits").at("warning_share"), 0.8);
  EXPECT_FALSE(state.at("status").contains("samples"));
  EXPECT_EQ(state.at("queue").at(0).at("run"), id);

  const Json live = page.json("/api/live?since=-1");
  EXPECT_EQ(live.at("next").get<std::int64_t>() - live.at("first").get<std::int64_t>() -
                static_cast<std::int64_t>(live.at("blocks").size()),
            0);
  EXPECT_EQ(live.at("blocks").at(0).size(), 6U);
  EXPECT_GT(live.at("now_ns").get<std::int64_t>(), live.at("blocks").back().at(5).get<std::int64_t>());

  // The list may be a second old.
  Json runs;
  ASSERT_TRUE(wait_until([&] { return !(runs = page.json("/api/runs?limit=5")).empty(); }));
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.at(0).at("id"), id);
  EXPECT_EQ(runs.at(0).at("outcome"), "completed");
  const httplib::Result manifest = page.get("/runs/" + id + "/files/run.json");
  ASSERT_TRUE(manifest);
  EXPECT_EQ(manifest->status, 200);
  EXPECT_EQ(Json::parse(manifest->body).at("name"), "shown");
  EXPECT_EQ(manifest->get_header_value("Content-Disposition"), "attachment; filename=\"" + id + "-run.json\"");
  const httplib::Result data = page.get("/runs/" + id + "/files/data_40ms.csv");
  ASSERT_TRUE(data);
  EXPECT_EQ(data->body, content_of(daemon.runs() / id / "data_40ms.csv"));

  // The tones of the experiment share a period of 20 s.
  ASSERT_TRUE(wait_until([&] { return page.json("/api/response").at("run") == id; }));
  EXPECT_FALSE(page.json("/api/response").at("unknown").get<std::string>().empty());
  EXPECT_EQ(page.end(), 0);
}

TEST(Web, ServesAPageThatMayLoadNothingButItself) {
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  const httplib::Result index = page.get("/");
  ASSERT_TRUE(index);
  ASSERT_EQ(index->status, 200);
  const std::string policy = index->get_header_value("Content-Security-Policy");
  EXPECT_EQ(policy.rfind("default-src 'self';", 0), 0U) << policy;
  EXPECT_EQ(policy.find("unsafe"), std::string::npos) << policy;
  EXPECT_EQ(index->get_header_value_count("Content-Security-Policy"), 1U);
  EXPECT_EQ(index->get_header_value("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(index->get_header_value("Referrer-Policy"), "no-referrer");
  // Everything that it names is there.
  const std::regex named("(?:src|href)=\"/?(static/[^\"]+)\"");
  std::size_t files = 0;
  for (std::sregex_iterator item(index->body.begin(), index->body.end(), named), end; item != end; ++item, ++files) {
    EXPECT_EQ(page.status_of("/" + (*item)[1].str()), 200) << (*item)[1];
  }
  EXPECT_GE(files, 3U);
  EXPECT_EQ(std::regex_search(index->body, std::regex("<script(?![^>]*src=)|<style|\\son[a-z]+=")), false)
      << "script or style within the HTML, which the policy forbids";
}

TEST(Web, RefusesOtherHostsOtherOriginsAndWaysOutOfTheRuns) {
  Daemon daemon;
  daemon.start();
  fs::create_directories(daemon.runs() / "20261122T100000Z-half" / "models");
  std::ofstream(daemon.runs() / "20261122T100000Z-half" / "run.json") << "{\"schema\": \"eha-ru";
  std::ofstream(daemon.folder() / "secret.csv") << "secret";
  fs::create_symlink(daemon.folder() / "secret.csv", daemon.runs() / "20261122T100000Z-half" / "link.csv");
  const Page page(daemon);
  ASSERT_TRUE(wait_until([&] { return connection(page) == "connected"; }));
  for (const char* host : {"evil.example", "evil.example:80", "127.0.0.1", "localhost"}) {
    EXPECT_EQ(page.status_of("/", {{"Host", host}}), 403) << host;
    EXPECT_EQ(page.status_of("/api/state", {{"Host", host}}), 403) << host;
  }
  EXPECT_EQ(page.status_of("/api/state", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(page.status_of("/api/state", {{"Sec-Fetch-Site", "cross-site"}}), 403);
  for (const char* path : {"/..",
                           "/../../etc/passwd",
                           "/%2e%2e/%2e%2e/etc/passwd",
                           "/static/../index.html",
                           "/static/%2e%2e%2findex.html",
                           "/static/",
                           "/static/nothing.js",
                           "/runs/",
                           "/runs/20261122T100000Z-half",
                           "/runs/20261122T100000Z-half/",
                           "/runs/20261122T100000Z-half/files/",
                           "/runs/20261122T100000Z-half/files/link.csv",
                           "/runs/20261122T100000Z-half/files/../../../secret.csv",
                           "/runs/20261122T100000Z-half/files/..%2f..%2fsecret.csv",
                           "/runs/../files/secret.csv",
                           "/runs/latest/report.html",
                           "/runs/20261122T100000Z-half/files/models",
                           "/runs/20261122T100000Z-half/report.html",
                           "/runs//etc/passwd",
                           "/api/",
                           "/api/nothing"}) {
    EXPECT_EQ(page.status_of(path), 404) << path;
  }
  EXPECT_EQ(page.status_of("/" + std::string(4000, 'a')), 414);
  // A run whose manifest is half written is named, and the page goes on.
  const Json runs = page.json("/api/runs");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs.at(0).at("outcome"), "unreadable");
  EXPECT_FALSE(runs.at(0).at("error").get<std::string>().empty());
  fs::remove_all(daemon.runs() / "20261122T100000Z-half");
  EXPECT_TRUE(wait_until([&] { return page.json("/api/runs").empty(); }));
}

TEST(Web, StopsTheRunAtOnceWithTheTokenAndNotWithoutIt) {
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  Client client(daemon.socket());
  client.call("arm");
  const std::int64_t entry = submit(client, quiet_experiment_text("stopped", 60.0), false);
  follow(daemon, entry,
         [](const Json& snapshot) { return snapshot.at("run").is_object() && snapshot.at("state") == "running"; });
  const auto status_of = [](const httplib::Result& answer) { return answer ? answer->status : 0; };
  EXPECT_EQ(status_of(page.stop({})), 401);
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", "0123456789abcdef0123456789abcdef"}})), 401);
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", page.token()}, {"Origin", "http://evil.example"}})), 403);
  EXPECT_EQ(page.status_of("/api/stop?token=" + page.token()), 405);
  EXPECT_EQ(status_of(page.post("/api/token", {{"X-Eha-Token", page.token()}})), 200);
  EXPECT_EQ(status_of(page.post("/api/token", {{"X-Eha-Token", page.token()}, {"Origin", "http://evil.example"}})),
            403);
  EXPECT_EQ(client.call("status").at("state"), "running");

  const httplib::Result stopped = page.stop({{"X-Eha-Token", page.token()}});
  ASSERT_TRUE(stopped);
  EXPECT_EQ(stopped->status, 200) << stopped->body;
  EXPECT_EQ(Json::parse(stopped->body).at("result"), "ramping_out");
  EXPECT_EQ(follow(daemon, entry).at("outcome"), "interrupted");

  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", page.token()}})), 409) << "nothing is on any more";
  for (int i = 0; i < 2; ++i) EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", "wrong"}})), 401);
  EXPECT_EQ(status_of(page.post("/api/token", {{"X-Eha-Token", "wrong"}})), 401) << "a check is a try too";
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", "wrong"}})), 429);
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", page.token()}})), 429);
}

TEST(Web, LetsNobodysWrongTokensKeepAnotherUserFromStopping) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  const auto status_of = [](const httplib::Result& answer) { return answer ? answer->status : 0; };
  ASSERT_EQ(seteuid(kOtherUser), 0);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", "wrong"}})), 401);
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", page.token()}})), 429);
  ASSERT_EQ(seteuid(0), 0);
  EXPECT_EQ(status_of(page.stop({{"X-Eha-Token", page.token()}})), 409) << "nothing is on";
  EXPECT_NE(page.log().find("wrong token of uid 65534"), std::string::npos) << page.log();
}

/// Sends a request on a connection of its own, again and again until the pipe `goes_on` has ended. For a process of its
/// own: only system calls. @returns whether each was answered or refused
bool storm(int port, std::string_view request, int goes_on) noexcept {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  for (pollfd end{.fd = goes_on, .events = POLLIN, .revents = 0}; poll(&end, 1, 0) == 0;) {
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return false;
    static_cast<void>(send(descriptor, request.data(), request.size(), MSG_NOSIGNAL));
    char answer[64];
    static_cast<void>(recv(descriptor, answer, sizeof answer, 0));
    close(descriptor);
  }
  return true;
}

TEST(Web, StopsTheRunDuringAStormOfWrongTokensOfAnotherUser) {
  if (!can_change_user()) GTEST_SKIP() << "needs two users";
  constexpr int kProcesses = 4;
  constexpr int kRuns = 3;
  const BeforeOthers before_others;
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  const std::string address = "127.0.0.1:" + std::to_string(page.port());
  const std::string wrong = "POST /api/stop HTTP/1.1\r\nHost: " + address + "\r\nOrigin: http://" + address +
                            "\r\nX-Eha-Token: 0123456789abcdef0123456789abcdef\r\nContent-Type: application/json\r\n"
                            "Content-Length: 2\r\nConnection: close\r\n\r\n{}";
  OtherUsersStorm storms(kProcesses, [&](int goes_on) { return storm(page.port(), wrong, goes_on); });
  double slowest_ms = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Client client(daemon.socket());
    client.call("arm");
    const std::int64_t entry = submit(client, quiet_experiment_text("stopped", 60.0), false);
    follow(daemon, entry,
           [](const Json& snapshot) { return snapshot.at("run").is_object() && snapshot.at("state") == "running"; });
    const auto begun = steady_clock::now();
    const httplib::Result stopped = page.stop({{"X-Eha-Token", page.token()}});
    const double took_ms = std::chrono::duration<double, std::milli>(steady_clock::now() - begun).count();
    slowest_ms = std::max(slowest_ms, took_ms);
    EXPECT_TRUE(stopped && stopped->status == 200) << (stopped ? stopped->body : "no answer");
    follow(daemon, entry);
  }
  EXPECT_TRUE(storms.all_could()) << "the storm ended early";
  std::printf("%d stops during the storm, the slowest %.1f ms\n", kRuns, slowest_ms);
  EXPECT_LT(slowest_ms, 500.0);
  EXPECT_NE(page.log().find("wrong token of uid 65534"), std::string::npos) << page.log();
}

TEST(Web, HandsOnTheNewestOfWhatIsOverAndSaysHowManyAreLeftOut) {
  Daemon daemon;
  daemon.start();
  Client client(daemon.socket());
  const std::int64_t first = submit(client, quiet_experiment_text("e", 2.0));
  client.call("cancel", {{"entry", first}});
  daemon.stop(SIGTERM);
  // As after a year: more than the service keeps.
  const fs::path queue = daemon.folder() / "state" / "queue";
  Json entry = Json::parse(content_of(queue / "00000001.json"));
  for (int i = 2; i <= 505; ++i) {
    entry["entry"] = i;
    entry["place"] = i;
    const std::string number = std::to_string(i);
    std::ofstream(queue / (std::string(8 - number.size(), '0') + number + ".json")) << entry.dump();
  }
  daemon.start();
  Client again(daemon.socket());
  EXPECT_EQ(again.call("queue").at("entries").size(), 500U) << "cancelled ones are forgotten as others are";
  const Json newest = again.call("queue", {{"over", 3}});
  EXPECT_EQ(newest.at("entries").size(), 3U);
  EXPECT_EQ(newest.at("entries").at(2).at("entry"), 505);
  EXPECT_EQ(newest.at("left_out"), 497);
  const std::int64_t waits = submit(again, quiet_experiment_text("waits", 2.0));
  const Page page(daemon);
  ASSERT_TRUE(wait_until([&] { return !page.json("/api/state").at("queue").empty(); }));
  const Json state = page.json("/api/state");
  EXPECT_EQ(state.at("queue").size(), 51U);
  EXPECT_EQ(state.at("queue").at(50).at("entry"), waits);
  EXPECT_EQ(state.at("queue_left_out"), 450);
  EXPECT_LT(state.dump().size(), 100'000U);
  again.call("cancel", {{"entry", waits}});
  EXPECT_EQ(again.call("queue").at("entries").size(), 500U) << "one cancelled more, one forgotten";
  EXPECT_EQ(again.call("queue").at("entries").back().at("entry"), waits);
}

TEST(Web, GoesOnWhenTheServiceDiesAndIsBack) {
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  ASSERT_TRUE(wait_until([&] { return connection(page) == "connected"; }));
  ASSERT_TRUE(wait_until([&] { return page.json("/api/live?since=-1").at("next") > 3; }));
  daemon.stop(SIGKILL);
  ASSERT_TRUE(wait_until([&] { return connection(page) == "lost"; }));
  const Json lost = page.json("/api/state");
  EXPECT_TRUE(lost.at("status").is_null());
  EXPECT_FALSE(lost.at("reason").get<std::string>().empty());
  const std::int64_t next = page.json("/api/live?since=-1").at("next");
  const httplib::Result stop = page.stop({{"X-Eha-Token", page.token()}});
  ASSERT_TRUE(stop);
  EXPECT_EQ(stop->status, 503) << stop->body;
  daemon.start();
  EXPECT_TRUE(wait_until([&] { return connection(page) == "connected"; })) << page.log();
  EXPECT_TRUE(wait_until([&] { return page.json("/api/live?since=" + std::to_string(next)).at("next") > next; }))
      << "the numbers go on";
}

TEST(Web, NamesTheEmergencyStopInTimeWhenTheServiceHangs) {
  Daemon daemon;
  daemon.start();
  const Page page(daemon);
  ASSERT_TRUE(wait_until([&] { return connection(page) == "connected"; }));
  ASSERT_EQ(kill(daemon.pid(), SIGSTOP), 0);
  for (int i = 0; i < 2; ++i) {
    const auto begun = steady_clock::now();
    const httplib::Result stop = page.stop({{"X-Eha-Token", page.token()}});
    EXPECT_LT(steady_clock::now() - begun, 2s);
    ASSERT_TRUE(stop);
    EXPECT_EQ(stop->status, 503) << stop->body;
    EXPECT_NE(stop->body.find("emergency stop"), std::string::npos) << stop->body;
  }
  kill(daemon.pid(), SIGCONT);
  EXPECT_TRUE(wait_until([&] { return connection(page) == "connected"; })) << page.log();
}

TEST(Web, TakesTheTokenFromAFileThatOthersCannotRead) {
  Daemon daemon;
  daemon.start();
  const fs::path file = daemon.folder() / "token";
  std::ofstream(file) << "a-token-of-the-bench\n";
  fs::permissions(file, fs::perms(0644));
  const Ended refused = run_eha({"web", "--port", "0", "--token-file", file.string()}, daemon.folder());
  EXPECT_EQ(refused.code, 78) << refused.err;
  EXPECT_NE(refused.err.find("chmod 0640"), std::string::npos) << refused.err;
  fs::permissions(file, fs::perms(0640));
  const Page page(daemon, {"--token-file", file.string(), "--allow-host", "localhost:9000"});
  ASSERT_TRUE(wait_until([&] { return connection(page) == "connected"; }));
  const httplib::Result answer = page.stop({{"X-Eha-Token", "a-token-of-the-bench"}});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 409) << answer->body;
  EXPECT_EQ(page.status_of("/", {{"Host", "localhost:9000"}}), 200);
}

}  // namespace
}  // namespace eha::test
