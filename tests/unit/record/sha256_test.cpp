// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/sha256.hpp"

#include <gtest/gtest.h>

#include <span>
#include <string>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

TEST(Sha256, HashesNoDeviceWhichHasNoEnd) { EXPECT_THROW(static_cast<void>(sha256_of_file("/dev/zero")), IoError); }

TEST(Sha256, HashesAsTheStandardsExamplesDo) {
  const test::TemporaryFolder folder;
  // FIPS 180-2, appendix B.1 and B.3, and the empty message.
  EXPECT_EQ(sha256_of_file(folder.write("abc", "abc")),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_of_file(folder.write("million", std::string(1'000'000, 'a'))),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(sha256_of_file(folder.write("empty", "")),
            "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256_of(std::as_bytes(std::span("abc", 3))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace eha::record
