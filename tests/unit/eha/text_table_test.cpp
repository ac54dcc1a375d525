// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include "daemon/eha/terminal_table.hpp"

namespace eha::cli {
namespace {

TEST(TextTable, AlignsByCharactersAndLeavesNoTrailingBlanks) {
  const std::string text = text_table({{"name", Align::left}, {"µm", Align::right}, {"note", Align::left}},
                                      {{"a", "1.5", "good"}, {"longer", "±12", ""}});
  EXPECT_EQ(text,
            "name     µm  note\n"
            "------  ---  ----\n"
            "a       1.5  good\n"
            "longer  ±12\n");
}

TEST(TextTable, HasOneLineForARowWhateverItsNamesHold) {
  EXPECT_EQ(text_table({{"run", Align::left}, {"s", Align::right}}, {{"a\nNext: eha arm", "1"}}),
            "run              s\n"
            "---------------  -\n"
            "a?Next: eha arm  1\n");
}

TEST(TextTable, HasTitlesWithoutRows) { EXPECT_EQ(text_table({{"a", Align::left}}, {}), "a\n-\n"); }

}  // namespace
}  // namespace eha::cli
