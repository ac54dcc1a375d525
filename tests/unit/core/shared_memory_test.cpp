// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/shared_memory.hpp"

#include <gtest/gtest.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>

#include "core/error.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::os {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSize = 10'000;

char* text(const SharedMemory& memory) { return static_cast<char*>(memory.data()); }

fs::path path_of(const SharedMemory& memory) { return "/proc/self/fd/" + std::to_string(memory.file().get()); }

TEST(SharedMemory, IsZeroAndTheSameForWhoeverMapsItsFile) {
  const SharedMemory one = SharedMemory::create(kSize);
  for (std::size_t i = 0; i < kSize; ++i) ASSERT_EQ(text(one)[i], 0);
  const SharedMemory other = SharedMemory::open(path_of(one), kSize);
  std::strcpy(text(one) + 9'000, "beat");
  EXPECT_STREQ(text(other) + 9'000, "beat");
}

TEST(SharedMemory, HasANameInMemoryAndOutlivesItsMaker) {
  const fs::path path = "/dev/shm/eha-memory-test-" + std::to_string(getpid());
  {
    const SharedMemory memory = SharedMemory::create(kSize, path);
    std::strcpy(text(memory), "row");
  }
  EXPECT_STREQ(text(SharedMemory::open(path, kSize)), "row");
  EXPECT_STREQ(text(SharedMemory::create(kSize, path)), "") << "the next run begins with fresh memory";
  fs::remove(path);
}

TEST(SharedMemory, HasNoNameOnADisk) {
  const test::TemporaryFolder folder;
  struct statfs facts {};
  constexpr long kTmpfs = 0x01021994;
  if (statfs(folder.path().c_str(), &facts) != 0 || facts.f_type == kTmpfs) GTEST_SKIP() << "/tmp is in memory";
  const SharedMemory memory = SharedMemory::create(kSize, folder.path() / "page");
  EXPECT_FALSE(fs::exists(folder.path() / "page"));
  EXPECT_NE(memory.data(), nullptr);
}

TEST(SharedMemory, RefusesAFileThatIsTooShort) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(static_cast<void>(SharedMemory::open(folder.write("short", "x"), kSize)), IoError);
  EXPECT_THROW(static_cast<void>(SharedMemory::open(folder.path() / "none", kSize)), IoError);
}

}  // namespace
}  // namespace eha::os
