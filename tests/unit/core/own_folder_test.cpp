// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/own_folder.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "tests/unit/other_users.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::os {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRemedy = "begin anew";

TEST(OwnFolder, IsMadeOnceItIsNeededAndKeepsItsFiles) {
  const test::TemporaryFolder above;
  OwnFolder folder(above.path() / "made" / "here" / "", kRemedy);
  EXPECT_FALSE(folder.read("a"));
  folder.make();
  EXPECT_FALSE(folder.read("a"));
  folder.write("a", "text");
  EXPECT_EQ(folder.read("a"), "text");
  EXPECT_NO_THROW(folder.require_own("a"));
  EXPECT_NO_THROW(folder.require_own("missing"));
  EXPECT_EQ(OwnFolder(above.path() / "made" / "here", kRemedy).read("a"), "text");
  folder.remove("a");
  EXPECT_FALSE(folder.read("a"));
}

TEST(OwnFolder, StaysTheOneThatWasCheckedWhateverIsPutInItsPlace) {
  const test::TemporaryFolder above;
  const fs::path path = above.path() / "folder";
  OwnFolder folder(path, kRemedy);
  folder.make();
  folder.write("a", "own");
  fs::rename(path, above.path() / "aside");
  fs::create_directory(path);
  above.write("folder/a", "another");
  EXPECT_EQ(folder.read("a"), "own");
  folder.write("a", "newer");
  EXPECT_EQ(test::content_of(path / "a"), "another");
  EXPECT_EQ(test::content_of(above.path() / "aside" / "a"), "newer");
  EXPECT_THROW(folder.require_own("a"), PermissionError) << "who opens it by its path gets the other one";
}

TEST(OwnFolder, ReadsNoLinkAndWaitsForNoPipe) {
  const test::TemporaryFolder above;
  OwnFolder folder(above.path() / "folder", kRemedy);
  folder.make();
  fs::create_symlink("/etc/passwd", above.path() / "folder" / "link");
  EXPECT_THROW(static_cast<void>(folder.read("link")), PermissionError);
  EXPECT_THROW(folder.require_own("link"), PermissionError);
  ASSERT_EQ(mkfifo((above.path() / "folder" / "pipe").c_str(), 0600), 0);
  EXPECT_THROW(static_cast<void>(folder.read("pipe")), IoError);
  fs::create_directory_symlink("folder", above.path() / "to_folder");
  EXPECT_THROW(OwnFolder(above.path() / "to_folder", kRemedy), PermissionError);
  EXPECT_THROW(OwnFolder(above.path() / "to_folder" / "", kRemedy), PermissionError);
  fs::create_symlink("nowhere", above.path() / "to_nowhere");
  EXPECT_THROW(OwnFolder(above.path() / "to_nowhere", kRemedy), PermissionError);
}

TEST(OwnFolder, OfRootIsTakenByAnybodyButNotThatOfAnotherUser) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give a folder to another user";
  struct stat facts {};
  facts.st_mode = S_IFREG | 0644;
  EXPECT_TRUE(is_changed_only_by(facts, {1000, 0}));
  facts.st_uid = 1001;
  EXPECT_FALSE(is_changed_only_by(facts, {1000, 0}));
  facts.st_uid = 1000;
  facts.st_mode = S_IFREG | 0664;
  EXPECT_FALSE(is_changed_only_by(facts, {1000, 0}));
  const test::TemporaryFolder above;
  ASSERT_EQ(chown(above.path().c_str(), test::kOtherUser, static_cast<gid_t>(-1)), 0);
  try {
    const OwnFolder folder(above.path(), kRemedy);
    FAIL() << "taken";
  } catch (const PermissionError& error) {
    const std::string said = error.what();
    EXPECT_NE(said.find("belongs to nobody"), std::string::npos) << said;
    EXPECT_NE(said.find(kRemedy), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace eha::os
