// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/line_buffer.hpp"

#include <gtest/gtest.h>

#include <string>

namespace eha::control {
namespace {

TEST(LineBuffer, GivesLinesHoweverTheyAreCut) {
  LineBuffer buffer(10);
  std::string seen;
  for (const char byte : std::string("one\r\n\ntwo\nrest")) {
    buffer.append({&byte, 1});
    while (const auto line = buffer.next_line()) seen += "[" + *line + "]";
  }
  EXPECT_EQ(seen, "[one][][two]");
  EXPECT_EQ(buffer.size(), 4U);
  EXPECT_FALSE(buffer.is_too_long());
}

TEST(LineBuffer, TakesTheLongestLineAndNoLonger) {
  LineBuffer buffer(4);
  buffer.append("1234\n12345\n1\n");
  EXPECT_EQ(buffer.next_line(), "1234");
  EXPECT_EQ(buffer.next_line(), std::nullopt);
  EXPECT_TRUE(buffer.is_too_long());
}

TEST(LineBuffer, KnowsThatALineIsTooLongBeforeItsEnd) {
  LineBuffer buffer(4);
  buffer.append("1234");
  EXPECT_FALSE(buffer.is_too_long());
  buffer.append("5");
  EXPECT_TRUE(buffer.is_too_long());
}

}  // namespace
}  // namespace eha::control
