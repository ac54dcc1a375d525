// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/access.hpp"

#include <gtest/gtest.h>

namespace eha::web {
namespace {

RequestHead get(std::string_view target, std::string host = "127.0.0.1:8420") {
  return {
      .method = "GET", .target = target, .host = {std::move(host)}, .origin = {}, .fetch_site = {}, .fetch_mode = {}};
}

RequestHead post(std::string origin) {
  RequestHead head = get("/api/stop");
  head.method = "POST";
  head.origin = {std::move(origin)};
  return head;
}

/// 0 when it may be answered.
int status_of(const AccessRules& rules, const RequestHead& head) {
  const auto denial = rules.check(head);
  EXPECT_TRUE(!denial || !denial->message.empty());
  return denial ? denial->status : 0;
}

TEST(AccessRules, KnowThePageByItsLoopbackNamesAndPortOnly) {
  const AccessRules rules(8420, {});
  for (const char* host : {"127.0.0.1:8420", "localhost:8420", "LocalHost:8420", "[::1]:8420"}) {
    EXPECT_EQ(status_of(rules, get("/", host)), 0) << host;
  }
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:80", "localhost", "localhost:8421", "evil.example:8420", "evil.example",
        "127.0.0.1.evil.example:8420", "localhost:8420@evil.example", "localhost:8420, evil.example", "[::2]:8420",
        "0.0.0.0:8420", "127.0.0.1:8420x", "127.0.0.1:", "127.0.0.1:8420 "}) {
    EXPECT_EQ(status_of(rules, get("/", host)), 403) << host;
  }
}

TEST(AccessRules, RefuseAMissingAndASecondHost) {
  const AccessRules rules(8420, {});
  RequestHead head = get("/");
  head.host.clear();
  EXPECT_EQ(status_of(rules, head), 403);
  head.host = {"127.0.0.1:8420", "evil.example"};
  EXPECT_EQ(status_of(rules, head), 403);
}

TEST(AccessRules, LeaveOutThePortOfTheUsualOne) { EXPECT_EQ(status_of(AccessRules(80, {}), get("/", "localhost")), 0); }

TEST(AccessRules, LetTheNamesPassThatWereAllowed) {
  const AccessRules rules(8420, {"Bench.lab", "localhost:9000"});
  EXPECT_EQ(status_of(rules, get("/", "bench.lab")), 0);
  EXPECT_EQ(status_of(rules, get("/", "bench.lab:1234")), 0) << "without a port: any";
  EXPECT_EQ(status_of(rules, get("/", "localhost:9000")), 0);
  EXPECT_EQ(status_of(rules, get("/", "localhost:9001")), 403);
  EXPECT_EQ(status_of(rules, get("/", "x.bench.lab")), 403);
}

TEST(AccessRules, TakeAPostFromThePageItselfOnly) {
  const AccessRules rules(8420, {});
  EXPECT_EQ(status_of(rules, post("http://127.0.0.1:8420")), 0);
  for (const char* origin : {"http://evil.example", "null", "https://127.0.0.1:8420", "http://localhost:8420",
                             "http://127.0.0.1:8421", "http://127.0.0.1:8420.evil.example", ""}) {
    EXPECT_EQ(status_of(rules, post(origin)), 403) << origin;
  }
  RequestHead without = post("");
  without.origin.clear();
  EXPECT_EQ(status_of(rules, without), 403) << "no browser leaves it out";
  RequestHead twice = post("http://127.0.0.1:8420");
  twice.origin.emplace_back("http://127.0.0.1:8420");
  EXPECT_EQ(status_of(rules, twice), 403);
}

TEST(AccessRules, RefuseWhatAnotherSiteReadsButNotALinkToThePage) {
  const AccessRules rules(8420, {});
  RequestHead read = get("/api/state");
  read.origin = {"http://evil.example"};
  EXPECT_EQ(status_of(rules, read), 403);
  RequestHead image = get("/api/state");
  image.fetch_site = {"cross-site"};
  image.fetch_mode = {"no-cors"};
  EXPECT_EQ(status_of(rules, image), 403);
  RequestHead link = get("/");
  link.fetch_site = {"cross-site"};
  link.fetch_mode = {"navigate"};
  EXPECT_EQ(status_of(rules, link), 0);
  link.target = "/runs/x/report.html";
  EXPECT_EQ(status_of(rules, link), 403);
  RequestHead own = get("/api/state");
  own.fetch_site = {"same-origin"};
  EXPECT_EQ(status_of(rules, own), 0);
}

TEST(AccessRules, RefuseMethodsAndPathsThatThePageDoesNotUse) {
  const AccessRules rules(8420, {});
  for (const char* method : {"PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", ""}) {
    RequestHead head = get("/");
    head.method = method;
    EXPECT_EQ(status_of(rules, head), 405) << method;
  }
  for (const char* path : {"/..", "/runs/../x", "/runs/%2e%2e/x", "/runs/a%2Fb", "/a%00", "/a\\b", "/runs/a..b"}) {
    EXPECT_EQ(status_of(rules, get(path)), 404) << path;
  }
  EXPECT_EQ(status_of(rules, get("/api/live?since=%31")), 0) << "a query may be encoded";
  EXPECT_EQ(status_of(rules, get("/" + std::string(511, 'a'))), 0);
  EXPECT_EQ(status_of(rules, get("/" + std::string(512, 'a'))), 414);
}

TEST(Host, IsANameOrAnAddressAndAPort) {
  for (const char* host : {"bench", "bench.lab:1", "10.0.0.1:65535", "[::1]", "[fe80::1]:80", "a_b-c"}) {
    EXPECT_TRUE(is_host(host)) << host;
  }
  for (const char* host :
       {"", ":80", "bench:", "bench:port", "bench:123456", "a b", "a/b", "[::1", "::1", "a@b", "[x]"}) {
    EXPECT_FALSE(is_host(host)) << host;
  }
}

}  // namespace
}  // namespace eha::web
