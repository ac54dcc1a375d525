// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/users.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/temporary_folder.hpp"

namespace {

using eha::os::accountable_user;
using eha::os::local_user_name;

class AccountableUser : public testing::Test {
 protected:
  AccountableUser() {
    std::ofstream(passwd_) << "root:x:0:0::/root:/bin/sh\nann:x:1001:1001::/home/ann:/bin/sh\n"
                              "bob:x:70001:70001::/home/bob:/bin/sh\n";
    std::ofstream(subuid_) << "nonsense\nann:100000:65536\n1002:165536:65536\ngone:231072:65536\nbob:4294901760:65535\n"
                              "ann:1:x\nroot:1000000:65536\n";
  }
  [[nodiscard]] uid_t of(uid_t uid) const { return accountable_user(uid, subuid_, passwd_); }

  eha::test::TemporaryFolder folder_;
  std::filesystem::path passwd_ = folder_.path() / "passwd";
  std::filesystem::path subuid_ = folder_.path() / "subuid";
};

TEST_F(AccountableUser, OfASubordinateUidIsItsOwner) {
  EXPECT_EQ(of(100000), 1001U);
  EXPECT_EQ(of(165535), 1001U);
  EXPECT_EQ(of(165536), 1002U) << "a range of a number";
  EXPECT_EQ(of(4294901760U), 70001U);
  EXPECT_EQ(of(4294967294U), 70001U);
}

TEST_F(AccountableUser, OfAContainerOfRootIsNobody) {
  EXPECT_EQ(of(1000123), 65534U) << "its users have none of root's rights";
}

TEST_F(AccountableUser, OfAnyOtherUidIsItself) {
  for (const uid_t uid : {0U, 1001U, 65535U, 70001U, 99999U, 231072U, 4294967295U}) EXPECT_EQ(of(uid), uid);
  EXPECT_EQ(accountable_user(100000, folder_.path() / "absent", passwd_), 100000U);
}

TEST_F(AccountableUser, HasItsLocalName) {
  EXPECT_EQ(local_user_name(70001, passwd_), "bob");
  EXPECT_EQ(local_user_name(70002, passwd_), "");
}

}  // namespace
