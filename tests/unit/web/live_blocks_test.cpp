// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/live_blocks.hpp"

#include <gtest/gtest.h>

namespace eha::web {
namespace {

using Json = nlohmann::ordered_json;

/// Blocks of 40 ms from a number of 40 ms on.
Json samples(int from, int count, int lost = 0) {
  Json blocks = Json::array();
  for (int i = from; i < from + count; ++i) {
    blocks.push_back({std::int64_t{i} * 40'000'000, 0.04 * i, 1.0 * i, 2.0 * i, -1.0, 1.0});
  }
  return {{"first", from}, {"lost", lost}, {"blocks", std::move(blocks)}};
}

TEST(LiveBlocks, HandOverEachBlockOnce) {
  LiveBlocks live;
  EXPECT_EQ(live.since(-1).next, 0);
  EXPECT_EQ(live.since(-1).blocks, "[]");
  live.add(samples(100, 3));
  const LiveBlocks::Part all = live.since(-1);
  EXPECT_EQ(all.first, 0);
  EXPECT_EQ(all.next, 3);
  EXPECT_EQ(all.dropped, 0);
  EXPECT_EQ(all.blocks,
            "[[4.0,100.0,200.0,-1.0,1.0,4000000000],[4.04,101.0,202.0,-1.0,1.0,4040000000],"
            "[4.08,102.0,204.0,-1.0,1.0,4080000000]]");
  EXPECT_EQ(live.since(all.next).blocks, "[]");
  live.add(samples(103, 1));
  const LiveBlocks::Part one = live.since(all.next);
  EXPECT_EQ(one.first, 3);
  EXPECT_EQ(Json::parse(one.blocks).size(), 1U);
}

TEST(LiveBlocks, CountThoseThatTheServiceNoLongerHad) {
  LiveBlocks live;
  live.add(samples(0, 2));
  live.add(samples(12, 2, 10));
  const LiveBlocks::Part part = live.since(2);
  EXPECT_EQ(part.next, 14);
  EXPECT_EQ(part.dropped, 10);
  EXPECT_EQ(part.first, 12);
  EXPECT_EQ(live.since(-1).dropped, 0);
}

TEST(LiveBlocks, KeepAMinute) {
  LiveBlocks live;
  live.add(samples(0, 2000));
  const LiveBlocks::Part part = live.since(0);
  const Json blocks = Json::parse(part.blocks);
  EXPECT_EQ(blocks.size(), 1501U);
  EXPECT_EQ(part.dropped, 499);
  EXPECT_EQ(part.first, 499);
}

TEST(LiveBlocks, KeepABoundedNumberWhenARunIsPlayedFast) {
  LiveBlocks live;
  Json at_once = samples(0, 5000);
  for (Json& block : at_once["blocks"]) block[0] = 7;
  live.add(at_once);
  EXPECT_EQ(Json::parse(live.since(-1).blocks).size(), LiveBlocks::kMost);
}

TEST(LiveBlocks, GiveAllToAPageThatWasOpenBeforeThisProcess) {
  LiveBlocks live;
  live.add(samples(0, 3));
  const LiveBlocks::Part part = live.since(1'000'000);
  EXPECT_EQ(part.first, 0);
  EXPECT_EQ(part.next, 3);
  EXPECT_EQ(part.dropped, 0);
  EXPECT_EQ(Json::parse(part.blocks).size(), 3U);
}

}  // namespace
}  // namespace eha::web
