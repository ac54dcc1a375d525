// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/delays/kernel_files.hpp"

#include <gtest/gtest.h>

namespace eha::delays {
namespace {

using Cpus = std::vector<int>;

TEST(CpuList, IsReadAsTheKernelWritesIt) {
  EXPECT_EQ(cpu_list("0-3"), (Cpus{0, 1, 2, 3}));
  EXPECT_EQ(cpu_list("0-1,5,8-9"), (Cpus{0, 1, 5, 8, 9}));
  EXPECT_EQ(cpu_list("3"), Cpus{3});
  EXPECT_EQ(cpu_list(""), Cpus{});
  EXPECT_EQ(cpu_list("none,2,-,4-,x-1,99999999999"), Cpus{2});
}

}  // namespace
}  // namespace eha::delays
