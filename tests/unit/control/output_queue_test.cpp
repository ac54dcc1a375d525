// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/output_queue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>

namespace eha::control {
namespace {

TEST(OutputQueue, GivesItsPartsInOrderWhateverIsTakenAtOnce) {
  for (const std::size_t most : {1U, 3U, 5U, 100U}) {
    OutputQueue queue;
    const auto shared = std::make_shared<const std::string>("a list");
    for (int i = 0; i < 2; ++i) {
      queue.add(std::string("<"));
      queue.add(shared);
      queue.add(std::string());
      queue.add(std::string(">\n"));
    }
    EXPECT_EQ(queue.size(), 18U);
    std::string sent;
    while (!queue.empty()) {
      const auto next = queue.front();
      ASSERT_FALSE(next.empty());
      const std::size_t count = std::min(most, next.size());
      sent += next.substr(0, count);
      queue.take(count);
    }
    EXPECT_EQ(sent, "<a list>\n<a list>\n") << most;
    EXPECT_EQ(queue.size(), 0U);
    EXPECT_EQ(shared.use_count(), 1) << "nothing is kept that was sent";
  }
}

}  // namespace
}  // namespace eha::control
