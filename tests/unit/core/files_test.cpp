// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/files.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <limits>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::os {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Files, ReplacesAFileAndLeavesNothingBeside) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.write("a.json", "old");
  write_file_atomically(path, "new");
  EXPECT_EQ(read_file(path), "new");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(Files, KeepsTheOldFileWhenTheNewOneIsGivenUp) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.write("a.json", "old");
  {
    AtomicFile file(path);
    file.write("half a ne");
    EXPECT_EQ(files_in(folder.path()), 2u);
  }
  EXPECT_EQ(read_file(path), "old");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(Files, WritesThroughNoLinkOfAnotherUser) {
  const test::TemporaryFolder folder;
  const std::filesystem::path victim = folder.write("victim", "keep me");
  const std::filesystem::path path = folder.path() / "rig.toml";
  std::filesystem::create_symlink(victim, folder.path() / ("rig.toml." + std::to_string(getpid()) + ".tmp"));
  write_file_atomically(path, "new");
  EXPECT_EQ(read_file(victim), "keep me");
  EXPECT_EQ(read_file(path), "new");
  EXPECT_FALSE(std::filesystem::is_symlink(path));
}

TEST(Files, PutsNoFileInThePlaceOfADeviceOrAPipe) {
  const test::TemporaryFolder folder;
  const std::filesystem::path pipe = folder.path() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(write_file_atomically(pipe, "x"), IoError);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
  // A link as /dev/stdout is one; as root a device itself would be replaced.
  const std::filesystem::path link = folder.path() / "null";
  std::filesystem::create_symlink("/dev/null", link);
  EXPECT_THROW(write_file_atomically(link, "x"), IoError);
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_EQ(files_in(folder.path()), 2u);
}

TEST(Files, SaysWhatIsMissing) {
  const test::TemporaryFolder folder;
  try {
    static_cast<void>(read_file(folder.path() / "absent"));
    FAIL() << "read a file that does not exist";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("absent: No such file or directory"), std::string::npos) << error.what();
  }
  EXPECT_THROW(write_file_atomically(folder.path() / "no" / "where", "x"), IoError);
}

TEST(Files, ReadsNoTextWithoutAnEndIntoMemory) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.write("model.json", "{");
  std::filesystem::resize_file(path, std::uintmax_t{300} << 30);  // a hole: nothing on the disk
  EXPECT_THROW(static_cast<void>(read_file(path)), DataError);
  EXPECT_THROW(static_cast<void>(read_file("/dev/zero")), DataError);
}

TEST(Files, RefusesARunThatTheDiskHasNoRoomFor) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(require_free_space(folder.path(), 1));
  EXPECT_THROW(require_free_space(folder.path(), std::numeric_limits<std::uint64_t>::max()), IoError);
}

TEST(Files, NameTheFileThatWasAskedForWhereItsTemporaryOneCannotBeMade) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "missing" / "model.json";
  const auto message_of = [](const auto& act) {
    try {
      act();
    } catch (const IoError& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  const std::string told = message_of([&] { write_file_atomically(file, "text"); });
  EXPECT_EQ(told.find(".tmp"), std::string::npos) << told;
  EXPECT_NE(told.find("cannot write " + file.string() + ":"), std::string::npos) << told;
  const std::string tried = message_of([&] { try_space(file.string() + ".tmp", 1000, file); });
  EXPECT_NE(tried.find("cannot write " + file.string() + ":"), std::string::npos) << tried;
}

TEST(Files, TriesForSpaceWithoutLeavingAFile) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(try_space(folder.path() / "probe", 100'000, "asked"));
  EXPECT_THROW(try_space(folder.path() / "probe", std::uint64_t{1} << 62, "asked"), IoError);
  EXPECT_EQ(files_in(folder.path()), 0u);
  folder.write("precious", "mine");
  std::filesystem::create_symlink("precious", folder.path() / "probe");
  try_space(folder.path() / "probe", 1000, "asked");
  EXPECT_EQ(test::content_of(folder.path() / "precious"), "mine") << "a link is not followed";
}

}  // namespace
}  // namespace eha::os
