// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/shell_word.hpp"

#include <gtest/gtest.h>

#include <cstdio>
#include <string>

namespace eha {
namespace {

/// What a shell makes of a command line's only argument.
std::string taken_by_shell(const std::string& word) {
  std::string taken;
  FILE* shell = popen(("printf %s " + word).c_str(), "r");
  for (int c = std::fgetc(shell); c != EOF; c = std::fgetc(shell)) taken += static_cast<char>(c);
  EXPECT_EQ(pclose(shell), 0);
  return taken;
}

TEST(ShellWord, IsOneWordOfTheShellWhateverItHolds) {
  for (int byte = 1; byte < 256; ++byte) {
    const std::string name = std::string("a") + static_cast<char>(byte) + "b";
    EXPECT_EQ(taken_by_shell(shell_word(name)), name) << "byte " << byte;
  }
  for (const char* name :
       {"$(echo x)", "`echo x`", "a;echo x", "a\necho x", "''", "'\"'$HOME", "*", "~", "#x", "a&&b"}) {
    EXPECT_EQ(taken_by_shell(shell_word(name)), name);
  }
}

TEST(ShellWord, LeavesOrdinaryNamesAsTheyAre) {
  EXPECT_EQ(shell_word("runs/20260101T000000Z-paper/models/io_valve.json"),
            "runs/20260101T000000Z-paper/models/io_valve.json");
  EXPECT_EQ(shell_word("b\xC3\xBChne.csv"), "b\xC3\xBChne.csv");
  EXPECT_EQ(shell_word(""), "''");
}

TEST(ShellWord, IsNoOptionOfTheCommandThatTakesIt) {
  EXPECT_EQ(shell_word("-rf"), "./-rf");
  EXPECT_EQ(shell_word("--socket=a b"), "'./--socket=a b'");
  EXPECT_EQ(taken_by_shell(shell_word("-e $HOME")), "./-e $HOME");
  EXPECT_EQ(shell_word("runs/-a"), "runs/-a");
  EXPECT_EQ(shell_quoted("--fast"), "--fast") << "an option of a whole command line stays one";
}

TEST(ShellWord, QuotesWhatATerminalShowsAsAPattern) {
  EXPECT_EQ(shell_word("\xC2\x85-twin=keep.toml"), "'\xC2\x85-twin=keep.toml'");
  EXPECT_EQ(shell_word("a\xE2\x80\xAEz"), "'a\xE2\x80\xAEz'");
}

}  // namespace
}  // namespace eha
