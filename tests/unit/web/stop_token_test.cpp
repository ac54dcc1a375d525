// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/stop_token.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::web {
namespace {

namespace fs = std::filesystem;
using Answer = StopToken::Answer;
using namespace std::chrono_literals;

constexpr const char* kText = "0123456789abcdef";
constexpr uid_t kAlice = 1000;
constexpr uid_t kBob = 1001;

TEST(StopTokenTest, IsRightWhenEveryCharacterIs) {
  StopToken token(kText);
  const auto now = StopToken::Clock::now();
  EXPECT_EQ(token.check(kText, kAlice, now), Answer::right);
  for (const char* wrong : {"", "0123456789abcdeF", "0123456789abcde", "0123456789abcdef0"}) {
    StopToken fresh(kText);
    EXPECT_EQ(fresh.check(wrong, kAlice, now), Answer::wrong) << wrong;
  }
}

TEST(StopTokenTest, TakesFiveWrongTriesInTenSecondsAndThenNoneAtAll) {
  StopToken token(kText);
  const auto start = StopToken::Clock::now();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(token.check("wrong", kAlice, start + i * 1s), Answer::wrong);
  EXPECT_EQ(token.check("wrong", kAlice, start + 5s), Answer::too_many);
  EXPECT_EQ(token.check(kText, kAlice, start + 9s), Answer::too_many);
  // The first wrong try is ten seconds old; refused tries do not count.
  EXPECT_EQ(token.check(kText, kAlice, start + 10s), Answer::right);
  EXPECT_EQ(token.check("wrong", kAlice, start + 10s), Answer::wrong);
  EXPECT_EQ(token.check(kText, kAlice, start + 10s), Answer::too_many);
}

TEST(StopTokenTest, KeepsNobodyElseFromStopping) {
  StopToken token(kText);
  const auto start = StopToken::Clock::now();
  for (int i = 0; i < 9; ++i) static_cast<void>(token.check("wrong", kAlice, start));
  EXPECT_EQ(token.check(kText, kAlice, start), Answer::too_many);
  EXPECT_EQ(token.check(kText, kBob, start), Answer::right);
  EXPECT_EQ(token.check(kText, std::nullopt, start), Answer::right);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(token.check("wrong", std::nullopt, start), Answer::wrong);
  EXPECT_EQ(token.check(kText, std::nullopt, start), Answer::too_many) << "those whose user is unknown are one";
  EXPECT_EQ(token.check(kText, kBob, start), Answer::right);
}

TEST(StopTokenTest, CountsNoRightTries) {
  StopToken token(kText);
  const auto now = StopToken::Clock::now();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(token.check(kText, kAlice, now), Answer::right);
}

TEST(StopTokenTest, RefusesATextThatIsTooShortOrUnprintableWithoutShowingIt) {
  for (const std::string& text : {std::string("short"), std::string("0123456789 abcdef"), std::string(257, 'a'),
                                  std::string("0123456789abcde\xff"), std::string()}) {
    try {
      const StopToken token(text);
      ADD_FAILURE() << text;
    } catch (const ConfigError& error) {
      EXPECT_TRUE(text.empty() || std::string(error.what()).find(text) == std::string::npos) << error.what();
    }
  }
}

TEST(StopTokenTest, ReadsTheFirstLineOfAFileThatOthersCannotRead) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.write("token", std::string(kText) + "\r\nmore\n");
  for (const unsigned mode : {0640U, 0600U, 0440U}) {
    fs::permissions(file, fs::perms(mode));
    EXPECT_EQ(StopToken::read(file), kText) << mode;
  }
  for (const unsigned mode : {0644U, 0660U, 0602U, 0641U}) {
    fs::permissions(file, fs::perms(mode));
    try {
      static_cast<void>(StopToken::read(file));
      ADD_FAILURE() << mode;
    } catch (const ConfigError& error) {
      EXPECT_NE(std::string(error.what()).find("chmod 0640"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(static_cast<void>(StopToken::read(folder.path() / "absent")), IoError);
  EXPECT_THROW(static_cast<void>(StopToken::read(folder.path())), ConfigError) << "a folder";
}

TEST(StopTokenTest, MakesATokenThatIsLongEnoughAndAnotherEachTime) {
  const std::string first = StopToken::random();
  EXPECT_EQ(first.size(), 32U);
  EXPECT_NE(first, StopToken::random());
  EXPECT_NO_THROW(StopToken token(first));
}

}  // namespace
}  // namespace eha::web
