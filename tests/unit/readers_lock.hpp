// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>

#include <filesystem>

#include "core/os/files.hpp"

namespace eha::test {

/// The locks that somebody can take who may read a file and not write to it.
inline os::FileDescriptor locked_by_a_reader(const std::filesystem::path& path) {
  os::FileDescriptor file = os::open_file(path, O_RDONLY);
  EXPECT_EQ(::flock(file.get(), LOCK_EX | LOCK_NB), 0);
  struct flock range {};
  range.l_type = F_WRLCK;
  EXPECT_NE(::fcntl(file.get(), F_OFD_SETLK, &range), 0);
  range.l_type = F_RDLCK;
  EXPECT_EQ(::fcntl(file.get(), F_OFD_SETLK, &range), 0);
  return file;
}

}  // namespace eha::test
