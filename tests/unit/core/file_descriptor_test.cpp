// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/os/file_descriptor.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <utility>

namespace eha::os {
namespace {

bool is_open(int descriptor) { return ::fcntl(descriptor, F_GETFD) >= 0; }

FileDescriptor open_null() { return FileDescriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

TEST(FileDescriptor, ClosesWhatItOwns) {
  int number = -1;
  {
    const FileDescriptor file = open_null();
    number = file.get();
    ASSERT_TRUE(is_open(number));
  }
  EXPECT_FALSE(is_open(number));
}

TEST(FileDescriptor, ClosesItsOldDescriptorWhenItTakesAnother) {
  FileDescriptor first = open_null();
  FileDescriptor second = open_null();
  const int old = first.get();
  const int taken = second.get();
  first = std::move(second);
  EXPECT_FALSE(is_open(old));
  EXPECT_EQ(first.get(), taken);
  EXPECT_TRUE(is_open(taken));
}

TEST(FileDescriptor, GivesItsDescriptorAwayOpen) {
  FileDescriptor file = open_null();
  FileDescriptor owner(file.release());
  EXPECT_FALSE(file);
  EXPECT_TRUE(is_open(owner.get()));
}

TEST(FileDescriptor, KeepsErrnoWhileItCloses) {
  FileDescriptor nothing(1 << 20);  // no such descriptor: close(2) fails
  errno = ENOSPC;
  nothing.close();
  EXPECT_EQ(errno, ENOSPC);
  EXPECT_FALSE(nothing);
}

}  // namespace
}  // namespace eha::os
