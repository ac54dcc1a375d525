// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/writer_lock.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "core/os/files.hpp"
#include "tests/unit/readers_lock.hpp"
#include "tests/unit/temporary_folder.hpp"

namespace eha::os {
namespace {

class WriterLock : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.write("journal", "rows");
  FileDescriptor reader_ = open_file(path_, O_RDONLY);
};

TEST_F(WriterLock, IsThatOfOneOpenFileUntilTheLastDescriptorOfItIsClosed) {
  FileDescriptor first = open_file(path_, O_RDWR);
  const FileDescriptor second = open_file(path_, O_RDWR);
  EXPECT_FALSE(has_writer(reader_, path_));
  EXPECT_TRUE(take_writer_lock(first, path_));
  EXPECT_TRUE(take_writer_lock(first, path_)) << "the lock is its own";
  EXPECT_FALSE(has_writer(first, path_)) << "the lock is its own";
  EXPECT_TRUE(has_writer(reader_, path_));
  EXPECT_FALSE(take_writer_lock(second, path_));
  FileDescriptor shared(dup(first.get()));  // as a guard has it
  first.close();
  EXPECT_TRUE(has_writer(reader_, path_));
  shared.close();
  EXPECT_FALSE(has_writer(reader_, path_));
  EXPECT_TRUE(take_writer_lock(second, path_));
}

TEST_F(WriterLock, IsNotKeptFromItsOwnerByAReader) {
  const FileDescriptor locked = test::locked_by_a_reader(path_);
  EXPECT_FALSE(has_writer(reader_, path_));
  EXPECT_TRUE(take_writer_lock(open_file(path_, O_RDWR), path_));
}

}  // namespace
}  // namespace eha::os
