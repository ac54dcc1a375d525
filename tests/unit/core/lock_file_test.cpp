// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/lock_file.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "tests/unit/other_users.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::os {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHolder = "another program; stop it first";

class LockFile : public ::testing::Test {
 protected:
  [[nodiscard]] std::string refusal() const {
    try {
      const FileDescriptor lock = lock_file(path_, kHolder);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  test::TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "lock";
};

TEST_F(LockFile, IsHeldByOneAtATimeAndOpenToItsOwnerOnly) {
  {
    const FileDescriptor lock = lock_file(path_, kHolder);
    EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
    EXPECT_NE(refusal().find(kHolder), std::string::npos) << refusal();
    EXPECT_THROW(static_cast<void>(lock_file(path_, kHolder)), DeviceError);
  }
  EXPECT_EQ(refusal(), "");
}

TEST_F(LockFile, ThatOthersCouldOpenIsReplaced) {
  folder_.write("lock", "");
  fs::permissions(path_, fs::perms::owner_read | fs::perms::owner_write | fs::perms::others_read);
  const FileDescriptor of_others = open_file(path_, O_RDONLY);
  const FileDescriptor lock = lock_file(path_, kHolder);
  EXPECT_EQ(flock(of_others.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_EQ(fs::status(path_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(LockFile, ThatOthersHoldIsNotSaidToBeTheProgramsOwn) {
  folder_.write("lock", "");
  fs::permissions(path_, fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  const FileDescriptor of_others = open_file(path_, O_RDONLY);
  ASSERT_EQ(flock(of_others.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_NE(refusal().find("other users may open this file"), std::string::npos) << refusal();
  EXPECT_NE(refusal().find("fuser " + path_.string()), std::string::npos) << refusal();
}

TEST_F(LockFile, IsNoLinkPipeOrFolder) {
  const fs::path victim = folder_.write("victim", "");
  fs::create_symlink(victim, path_);
  EXPECT_NE(refusal(), "");
  fs::remove(path_);
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  EXPECT_NE(refusal(), "");
  fs::remove(path_);
  fs::create_directory(path_);
  EXPECT_NE(refusal(), "");
}

TEST_F(LockFile, OfAnotherUserIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root, to give a file to another user";
  folder_.write("lock", "");
  ASSERT_EQ(chown(path_.c_str(), test::kOtherUser, static_cast<gid_t>(-1)), 0);
  EXPECT_NE(refusal().find("belongs to "), std::string::npos) << refusal();
}

}  // namespace
}  // namespace eha::os
