// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/own_file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::record {
namespace {

TEST(ListedFile, StaysInItsFolderAndIsAFile) {
  const test::TemporaryFolder folder;
  const auto run = folder.path() / "run";
  std::filesystem::create_directories(run / "models");
  folder.write("private.json", "{}");
  folder.write("run/models/io.json", "{}");
  EXPECT_EQ(listed_file(run, "models/io.json"), run / "models/io.json");
  EXPECT_EQ(listed_file(run, "models/missing.json"), run / "models/missing.json");
  for (const std::string& name :
       {(folder.path() / "private.json").string(), std::string("../private.json"),
        std::string("models/../../private.json"), std::string("/dev/zero"), std::string("models")}) {
    EXPECT_THROW(static_cast<void>(listed_file(run, name)), DataError) << name;
  }
  std::filesystem::create_symlink(folder.path() / "private.json", run / "models/link.json");
  std::filesystem::create_directory_symlink(folder.path(), run / "outside");
  ASSERT_EQ(mkfifo((run / "pipe.json").c_str(), 0600), 0);
  for (const char* name : {"models/link.json", "outside/private.json", "pipe.json"}) {
    EXPECT_THROW(static_cast<void>(listed_file(run, name)), DataError) << name;
  }
}

}  // namespace
}  // namespace eha::record
