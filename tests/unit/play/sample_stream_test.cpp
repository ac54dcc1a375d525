// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/play/sample_stream.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <thread>

namespace eha::play {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kNone = SampleBlock::kNone;

SampleBlock numbered(std::uint64_t number) {
  SampleBlock block;
  block.utc_ns = static_cast<std::int64_t>(number);
  block.displacement_min_in = static_cast<double>(number);
  block.displacement_max_in = static_cast<double>(number);
  return block;
}

TEST(SampleStream, HandsOverEachBlockOnceToAReaderThatKeepsUp) {
  SampleStream stream;
  std::uint64_t next = stream.next();
  EXPECT_TRUE(stream.since(next).blocks.empty());
  for (std::uint64_t i = 0; i < 3; ++i) stream.add(numbered(i));
  const SampleStream::Part part = stream.since(next);
  EXPECT_EQ(part.first, 0U);
  EXPECT_EQ(part.lost, 0U);
  ASSERT_EQ(part.blocks.size(), 3U);
  EXPECT_EQ(part.blocks[2].utc_ns, 2);
  next = part.first + part.blocks.size();
  EXPECT_TRUE(stream.since(next).blocks.empty());
  EXPECT_EQ(stream.next(), 3U);
}

TEST(SampleStream, SaysHowManyBlocksASlowReaderHasLost) {
  SampleStream stream;
  constexpr std::uint64_t kAdded = SampleStream::kKept + 10;
  for (std::uint64_t i = 0; i < kAdded; ++i) stream.add(numbered(i));
  const SampleStream::Part part = stream.since(3);
  EXPECT_EQ(part.first, 10U);
  EXPECT_EQ(part.lost, 7U);
  ASSERT_EQ(part.blocks.size(), SampleStream::kKept);
  EXPECT_EQ(part.blocks.front().utc_ns, 10);
  EXPECT_EQ(part.blocks.back().utc_ns, static_cast<std::int64_t>(kAdded) - 1);
  // A number from before a restart of the service.
  const SampleStream::Part beyond = stream.since(1'000'000);
  EXPECT_EQ(beyond.first, kAdded);
  EXPECT_EQ(beyond.lost, 0U);
  EXPECT_TRUE(beyond.blocks.empty());
}

TEST(SampleStream, IsWholeForAReaderBesideTheWriter) {
  const auto stream = std::make_unique<SampleStream>();
  constexpr std::uint64_t kAdded = 20'000;
  std::thread writer([&] {
    for (std::uint64_t i = 0; i < kAdded; ++i) stream->add(numbered(i));
  });
  std::uint64_t next = 0;
  while (next < kAdded) {
    const SampleStream::Part part = stream->since(next);
    EXPECT_EQ(part.first, next + part.lost);
    for (std::size_t i = 0; i < part.blocks.size(); ++i) {
      ASSERT_EQ(part.blocks[i].utc_ns, static_cast<std::int64_t>(part.first + i));
      ASSERT_EQ(part.blocks[i].displacement_max_in, static_cast<double>(part.first + i));
    }
    next = part.first + part.blocks.size();
  }
  writer.join();
}

TEST(BlockMaker, KeepsTheLeastAndTheGreatestOfEveryFortyMilliseconds) {
  SampleStream stream;
  BlockMaker maker(stream, BlockMaker::Kind::run);
  for (std::int64_t k = 0; k < 90; ++k) {
    const auto x = static_cast<double>(k);
    maker.add({k * kTick_ns, 5 + k * kTick_ns, x, -x});
  }
  EXPECT_EQ(stream.next(), 2U) << "the third block has 10 of its 40 samples";
  maker.finish();
  maker.finish();
  const SampleStream::Part part = stream.since(0);
  ASSERT_EQ(part.blocks.size(), 3U);
  EXPECT_EQ(part.blocks[0].displacement_min_in, 0.0);
  EXPECT_EQ(part.blocks[0].displacement_max_in, 39.0);
  EXPECT_EQ(part.blocks[1].applied_min_V, -79.0);
  EXPECT_EQ(part.blocks[1].applied_max_V, -40.0);
  EXPECT_DOUBLE_EQ(part.blocks[1].run_s, 0.079);
  EXPECT_EQ(part.blocks[1].utc_ns, 5 + 79 * kTick_ns);
  EXPECT_EQ(part.blocks[2].displacement_max_in, 89.0);
}

TEST(BlockMaker, PassesOverSamplesThatWereNotMeasured) {
  SampleStream stream;
  BlockMaker maker(stream, BlockMaker::Kind::run);
  maker.add({0, 0, kNone, 1.0});
  maker.add({1 * kTick_ns, 0, 2.5, 1.5});
  maker.add({2 * kTick_ns, 0, kNone, kNone});
  maker.add({40 * kTick_ns, 0, kNone, 0.5});
  maker.finish();
  const SampleStream::Part part = stream.since(0);
  ASSERT_EQ(part.blocks.size(), 2U);
  EXPECT_EQ(part.blocks[0].displacement_min_in, 2.5);
  EXPECT_EQ(part.blocks[0].displacement_max_in, 2.5);
  EXPECT_EQ(part.blocks[0].applied_max_V, 1.5);
  EXPECT_TRUE(std::isnan(part.blocks[1].displacement_min_in));
}

TEST(BlockMaker, SaysNoRunTimeOfARigThatIsNotDriven) {
  SampleStream stream;
  BlockMaker maker(stream, BlockMaker::Kind::idle);
  maker.add({1'000'000 * kTick_ns, 7, 3.0});
  maker.finish();
  const SampleStream::Part part = stream.since(0);
  ASSERT_EQ(part.blocks.size(), 1U);
  EXPECT_TRUE(std::isnan(part.blocks[0].run_s));
  EXPECT_TRUE(std::isnan(part.blocks[0].applied_min_V));
  EXPECT_EQ(part.blocks[0].displacement_min_in, 3.0);
}

}  // namespace
}  // namespace eha::play
