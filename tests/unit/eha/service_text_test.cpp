// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/service_text.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>

namespace eha::cli {
namespace {

using Json = nlohmann::ordered_json;

TEST(EndTimes, FollowOneAnotherFromTheStartOfTheRun) {
  setenv("TZ", "UTC", 1);
  tzset();
  const Json entries{{{"state", "over"}, {"duration_s", 120.0}, {"run", "20261123T100000Z-goto"}},
                     {{"state", "running"}, {"duration_s", 600.0}, {"run", "20261123T235500Z-paper"}},
                     {{"state", "waiting"}, {"duration_s", 120.0}, {"run", ""}},
                     {{"state", "held"}, {"duration_s", 120.0}, {"run", ""}},
                     {{"state", "waiting"}, {"duration_s", 60.0}, {"run", ""}, {"fast", true}},
                     {{"state", "waiting"}, {"duration_s", 180.0}, {"run", ""}}};
  EXPECT_EQ(end_times(entries), (std::vector<std::string>{"", "00:05", "00:07", "", "", "00:10"}));
}

TEST(EndTimes, AreUnknownWhereNothingIsPlayed) {
  const Json entries{{{"state", "waiting"}, {"duration_s", 120.0}, {"run", ""}}};
  EXPECT_EQ(end_times(entries), std::vector<std::string>{""});
}

}  // namespace
}  // namespace eha::cli
