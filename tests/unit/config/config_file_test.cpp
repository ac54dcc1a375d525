// SPDX-License-Identifier: GPL-3.0-or-later
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "config/experiment_config.hpp"
#include "config/file_kind.hpp"
#include "config/rig_config.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

namespace eha::config {
namespace {

class ConfigFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "eha_config_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    directory_ = pattern;
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string file(const std::string& content) {
    const std::string path = directory_ + "/x.toml";
    std::ofstream(path, std::ios::binary) << content;
    return path;
  }

  /// The same refusal for either kind of file.
  static std::string refusal(const std::string& path) {
    std::string rig;
    std::string experiment;
    try {
      (void)load_rig(path);
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.exit_code(), ExitCode::configuration);
      rig = error.what();
    }
    try {
      (void)load_experiment(path);
    } catch (const ConfigError& error) {
      experiment = error.what();
    }
    EXPECT_EQ(rig, experiment);
    return rig;
  }

  std::string directory_;
};

TEST_F(ConfigFile, ThatIsMissingIsNamed) {
  EXPECT_EQ(refusal(directory_ + "/absent.toml"),
            directory_ + "/absent.toml: cannot be read: No such file or directory; check the path");
}

TEST_F(ConfigFile, ThatIsADirectoryIsRefused) {
  EXPECT_EQ(refusal(directory_), directory_ + ": expected a configuration file, got a directory; name a file in it");
}

TEST_F(ConfigFile, ThatIsAPipeIsWaitedForOnlyWhereSomebodyWrites) {
  const std::string path = directory_ + "/pipe.toml";
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_EQ(read_config_file(path), "");
  const int end = open(path.c_str(), O_RDWR | O_CLOEXEC);  // does not wait for another end
  ASSERT_EQ(write(end, "schema = ", 9), 9);
  std::thread writer([end] {
    // Once the first part has been read, the reader waits for the next one.
    for (int unread = 1; unread > 0;) ioctl(end, FIONREAD, &unread);
    EXPECT_EQ(write(end, "1\n", 2), 2);
    close(end);
  });
  EXPECT_EQ(read_config_file(path), "schema = 1\n");
  writer.join();
}

TEST_F(ConfigFile, ThatIsEmptyIsRefused) {
  for (const char* content : {"", "\n \t\n"}) {
    const std::string path = file(content);
    EXPECT_EQ(refusal(path),
              path + ": expected a configuration file, got an empty one; start from one of the shipped ones");
  }
}

TEST_F(ConfigFile, ThatIsBinaryIsRefused) {
  const std::string path =
      file(std::string("\x7f"
                       "ELF\x02\0\0",
                       7));
  EXPECT_EQ(refusal(path), path + ": expected a configuration file in TOML, got a binary file");
}

TEST_F(ConfigFile, WithADecimalCommaIsToldWhatToWrite) {
  EXPECT_NE(refusal(file("# a\nduration_s = 20,05\n")).find("; a decimal comma? Write 20.05"), std::string::npos);
  EXPECT_NE(refusal(file("tones = [{ frequency_Hz = 0.05, amplitude_V = 1,9, phase_rad = 1.8 }]\n"))
                .find("; a decimal comma? Write 1.9"),
            std::string::npos);
  EXPECT_NE(refusal(file("# a\nduration_s = -0,3\n")).find("; a decimal comma? Write -0.3"), std::string::npos);
  EXPECT_NE(refusal(file("duration_s = 3,5")).find("Write 3.5"), std::string::npos);
  for (const char* text : {"a = ,5\n", "a = 5,\n", "a = [1,5\n", "a = 1 2\n", ","}) {
    EXPECT_EQ(refusal(file(text)).find("decimal comma"), std::string::npos) << text;
  }
}

TEST_F(ConfigFile, WithAWrongValueIsToldWhatIsWrittenAndWhatToWrite) {
  const auto says = [&](const std::string& text, const std::string& what) {
    const std::string said = refusal(file(text));
    EXPECT_NE(said.find(what), std::string::npos) << said;
    EXPECT_EQ(said.find("Error while"), std::string::npos) << said;
  };
  says("schema = 1\nkind = triangle  # slow\n", ":2:");
  says("schema = 1\nkind = triangle  # slow\n",
       "kind has the value triangle without quotes; a text needs them: kind = \"triangle\"");
  says("name = multisine one\n", "name = \"multisine one\"");
  says("hold = True\n", "hold has the value True; write hold = true");
  says("name =\nkind = 1\n", "\"name =\" has no value; write one behind the =");
  EXPECT_NE(refusal(file("a = 1 2\n")).find("expected TOML, got a syntax error"), std::string::npos);
}

TEST_F(ConfigFile, ThatIsFarTooLargeIsRefused) {
  const std::string path = file(std::string(3'000'000, '#'));
  EXPECT_EQ(refusal(path), path + ": expected a configuration file of at most 1 MiB, got more; check the path");
}

TEST_F(ConfigFile, ThatMayNotBeReadIsAMatterOfPermission) {
  const std::string path = file("schema = 1\n");
  std::filesystem::permissions(path, std::filesystem::perms::none);
  // Root may read everything, so it becomes somebody else for a moment.
  constexpr uid_t kNobody = 65534;
  const uid_t user = geteuid();
  if (user == 0 && seteuid(kNobody) != 0) GTEST_SKIP() << "root cannot change its user here";
  EXPECT_THROW((void)load_rig(path), PermissionError);
  ASSERT_EQ(seteuid(user), 0);
}

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

TEST(ConfigText, ThatIsNestedVeryDeepIsRefused) {
  const std::string nested = "a" + repeated(".a", 24) + "=[{\n";
  for (const std::string& text : {"a" + repeated(".a", 200'000) + " = 1\n", "[a" + repeated(".a", 200'000) + "]\n",
                                  "1" + repeated(".1", 200'000) + " = 1\n", "1" + repeated(".1 .1", 200'000) + " = 1\n",
                                  repeated("a={", 200'000), "a = " + repeated("[", 900'000), repeated("[", 900'000),
                                  repeated(nested, 10'000), repeated(nested, 100) + "?"}) {
    EXPECT_THROW((void)parse_rig(text, "x.toml"), ConfigError) << text.substr(0, 20);
    EXPECT_THROW((void)kind_of(text, "x.toml"), ConfigError) << text.substr(0, 20);
  }
}

TEST(ConfigText, MayHoldManyNumbersInALine) {
  const std::string tone = "{ frequency_Hz = 0.05, amplitude_V = 0.025, phase_rad = 1.5 },";
  const ExperimentConfig experiment =
      parse_experiment("schema = 1\nname = \"x\"\nduration_s = 10.0\n[excitation]\nkind = \"multisine\"\ntones = [" +
                           repeated(tone, 100) + "]\n[[model]]\nname = \"io\"\nstructure = \"io\"\n",
                       "x.toml");
  EXPECT_EQ(std::get<ident::Multisine>(experiment.played()->excitation.kind).tones.size(), 100U);
}

TEST_F(ConfigFile, IsReadAsItStands) {
  const std::string path = file("schema = 1\r\n# end without newline");
  EXPECT_EQ(read_config_file(path), "schema = 1\r\n# end without newline");
}

TEST(FileKind, FollowsTheKeysAtTheTop) {
  EXPECT_EQ(kind_of("backend = \"sim\"\n", "x"), FileKind::rig);
  EXPECT_EQ(kind_of("[limits]\n[sim]\n[record]\n", "x"), FileKind::rig);
  EXPECT_EQ(kind_of("duration_s = 1\n", "x"), FileKind::experiment);
  EXPECT_EQ(kind_of("[[model]]\n", "x"), FileKind::experiment);
}

TEST(FileKind, IsRefusedWhereItCannotBeTold) {
  for (const char* text : {"schema = 1\n", "[limits]\n[record]\n"}) EXPECT_THROW((void)kind_of(text, "x"), ConfigError);
  EXPECT_THROW((void)kind_of("schema = = 1\n", "x"), ConfigError);
}

TEST(Suggestion, NamesTheNearestKeyOrAllWhenNoneIsNear) {
  EXPECT_EQ(suggestion("duration", {"discard_s", "duration_s"}), " (did you mean \"duration_s\"?)");
  EXPECT_EQ(suggestion("hold", {"levels", "hold_s"}), " (did you mean \"hold_s\"?)");
  EXPECT_EQ(suggestion("zzz", {"levels", "hold_s"}), " (one of levels, hold_s)");
  EXPECT_EQ(suggestion(std::string(1'000'000, 'x'), {"a", "b"}), " (one of a, b)");
  EXPECT_EQ(suggestion("x", {}), "");
}

TEST(EditDistance, CountsInsertionsDeletionsAndSubstitutions) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("fti", "fit"), 1U) << "two letters are exchanged";
  EXPECT_EQ(edit_distance("ca", "abc"), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("abc", "abc"), 0U);
}

TEST(Shortened, KeepsPlainTextAndMasksTheRest) {
  EXPECT_EQ(shortened("plain text", 20), "plain text");
  EXPECT_EQ(shortened("a\x1b[31m\xff", 20), "a?[31m?");
  EXPECT_EQ(shortened("abcdef", 3), "abc...");
}

}  // namespace
}  // namespace eha::config
