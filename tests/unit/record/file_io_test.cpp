// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/file_io.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <limits>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(FileIo, HashesAsTheStandardsExamplesDo) {
  const test::TemporaryFolder folder;
  // FIPS 180-2, appendix B.1 and B.3, and the empty message.
  EXPECT_EQ(sha256_of_file(folder.write("abc", "abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_file(folder.write("million", std::string(1'000'000, 'a'))),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256_of_file(folder.write("empty", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(FileIo, ReplacesAFileAndLeavesNothingBeside) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder.write("a.json", "old");
  write_file_atomically(path, "new");
  EXPECT_EQ(read_file(path), "new");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(FileIo, KeepsTheOldFileWhenTheNewOneIsGivenUp) {
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

TEST(FileIo, SaysWhatIsMissing) {
  const test::TemporaryFolder folder;
  try {
    static_cast<void>(read_file(folder.path() / "absent"));
    FAIL() << "read a file that does not exist";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("absent: No such file or directory"), std::string::npos) << error.what();
  }
  EXPECT_THROW(write_file_atomically(folder.path() / "no" / "where", "x"), IoError);
}

TEST(FileIo, RefusesARunThatTheDiskHasNoRoomFor) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(require_free_space(folder.path(), 1));
  EXPECT_THROW(require_free_space(folder.path(), std::numeric_limits<std::uint64_t>::max()), IoError);
}

TEST(FileIo, TriesForSpaceWithoutLeavingAFile) {
  const test::TemporaryFolder folder;
  EXPECT_NO_THROW(try_space(folder.path() / "probe", 100'000));
  EXPECT_THROW(try_space(folder.path() / "probe", std::uint64_t{1} << 62), IoError);
  EXPECT_EQ(files_in(folder.path()), 0u);
}

}  // namespace
}  // namespace eha::record
