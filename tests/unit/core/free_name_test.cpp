// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/free_name.hpp"

#include <gtest/gtest.h>

#include "tests/unit/temporary_folder.hpp"

namespace eha {
namespace {

TEST(FreeName, NumbersWhatIsTaken) {
  const test::TemporaryFolder folder;
  folder.write("rig.toml", "");
  folder.write("rig-2.toml", "");
  const auto in = [&](const char* name) { return (folder.path() / name).string(); };
  EXPECT_EQ(free_name(in("other.toml")), in("other.toml"));
  EXPECT_EQ(free_name(in("rig.toml")), in("rig-3.toml"));
  EXPECT_EQ(next_free_name(in("models/")), in("models-2"));
  EXPECT_EQ(next_free_name(in("drift0.02")), in("drift0.02-2")) << "a number is no kind of file";
}

}  // namespace
}  // namespace eha
