// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/terminal_text.hpp"

#include <gtest/gtest.h>

namespace eha {
namespace {

TEST(TerminalText, LetsNothingThroughThatControlsATerminal) {
  EXPECT_EQ(terminal_text("a\x1b[2J\x1b]0;x\a\r\b\x7f"), "a?[2J?]0;x????");
  EXPECT_EQ(terminal_text(std::string_view("a\0b", 3)), "a?b");
  EXPECT_EQ(terminal_text("\xC2\x9B"
                          "31m\xC2\x80\xC2"),
            "?31m?\xC2");
}

TEST(TerminalText, LetsNoControlOfEightBitsThrough) {
  EXPECT_EQ(terminal_text("a\x9B"
                          "31m\x85\xE4\xC5\x9B\xE6\xB2\x9B\x9F"),
            "a?31m?\xE4\xC5\x9B\xE6\xB2\x9B?");
}

TEST(TerminalText, ShowsALineInTheOrderInWhichItIsCopied) {
  EXPECT_EQ(terminal_text("eha fit \xE2\x80\xAEvsc.exe\xE2\x81\xA9 \xE2\x80"), "eha fit ?vsc.exe? \xE2?");
  EXPECT_EQ(terminal_text("\xE2\x80\xAA\xE2\x81\xA6x\xE2\x80\xA9\xE2\x81\xA5"), "??x\xE2\x80\xA9\xE2\x81\xA5");
  EXPECT_EQ(terminal_text("a\xE2\x80\x8F"
                          "b\xE2\x80\x8E"
                          "c\xD8\x9C\xD8\x9D"),
            "a?b?c?\xD8\x9D");
}

TEST(TerminalText, KeepsLinesTabsAndEveryLanguage) {
  constexpr std::string_view kText =
      "Weg [mm]\tf\xC3\xBCr \xE2\x80\x99x\xE2\x80\x99 \xC2\xB5m\n\xE6\xB2\xB9\xF0\x9F\x94\xA7\n";
  EXPECT_EQ(terminal_text(kText), kText);
}

TEST(OneLine, EndsNoLineWhateverTheNameHolds) {
  EXPECT_EQ(one_line("fo\nNext: eha arm\r\n\tx\v\f"), "fo?Next: eha arm???x??");
  EXPECT_EQ(one_line("a\xC2\x85"
                     "b\xE2\x80\xA8"
                     "c\xE2\x80\xA9 \xE2\x80\x99\xC2\xB5m\xE2\x80"),
            "a?b?c? \xE2\x80\x99\xC2\xB5m\xE2?");
}

}  // namespace
}  // namespace eha
