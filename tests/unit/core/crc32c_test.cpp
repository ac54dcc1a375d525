// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/crc32c.hpp"

#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <string>

namespace eha {
namespace {

std::uint32_t reference(const char* data, std::size_t size) {
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(data, size);
  return static_cast<std::uint32_t>(crc.checksum());
}

TEST(Crc32c, HasTheCheckValueOfItsPolynomial) { EXPECT_EQ(Crc32c().add("123456789", 9).value(), 0xE3069283U); }

TEST(Crc32c, IsTheSameForEveryLengthAlignmentAndCut) {
  std::string bytes;
  for (unsigned k = 0; k < 300; ++k) bytes += static_cast<char>((k * 2654435761U) >> 13U);
  for (std::size_t first = 0; first < 9; ++first) {
    for (std::size_t size = 0; size + first <= bytes.size(); ++size) {
      const char* at = bytes.data() + first;
      const std::uint32_t whole = reference(at, size);
      EXPECT_EQ(Crc32c().add(at, size).value(), whole) << first << ", " << size;
      const std::size_t cut = size * 5 / 7;
      EXPECT_EQ(Crc32c().add(at, cut).add(at + cut, size - cut).value(), whole) << first << ", " << size;
    }
  }
}

}  // namespace
}  // namespace eha
