// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace eha {

/// CRC-32C (Castagnoli), as in iSCSI, RFC 3720: polynomial 0x1EDC6F41, reflected, complemented at both ends. Eight
/// bytes a step, by tables: Kounavis and Berry, "A Systematic Approach to Building High Performance, Software-based,
/// CRC Generators", ISCC 2005.
class Crc32c {
 public:
  Crc32c& add(const void* data, std::size_t size) noexcept {
    const auto* bytes = static_cast<const unsigned char*>(data);
    const auto entry = [](std::size_t table, std::uint32_t byte) { return kTables[table][byte & 0xFFU]; };
    const auto four = [](const unsigned char* at) {
      return static_cast<std::uint32_t>(at[0]) | static_cast<std::uint32_t>(at[1]) << 8U |
             static_cast<std::uint32_t>(at[2]) << 16U | static_cast<std::uint32_t>(at[3]) << 24U;
    };
    for (; size >= 8; size -= 8, bytes += 8) {
      const std::uint32_t low = crc_ ^ four(bytes);
      const std::uint32_t high = four(bytes + 4);
      crc_ = entry(7, low) ^ entry(6, low >> 8U) ^ entry(5, low >> 16U) ^ entry(4, low >> 24U) ^ entry(3, high) ^
             entry(2, high >> 8U) ^ entry(1, high >> 16U) ^ entry(0, high >> 24U);
    }
    for (; size > 0; --size, ++bytes) crc_ = crc_ >> 8U ^ entry(0, crc_ ^ *bytes);
    return *this;
  }
  [[nodiscard]] std::uint32_t value() const noexcept { return ~crc_; }

 private:
  using Table = std::array<std::uint32_t, 256>;

  /// Table k: what a byte does to the remainder k bytes later.
  static constexpr std::array<Table, 8> tables() {
    constexpr std::uint32_t kReflected = 0x82F63B78;
    std::array<Table, 8> all{};
    for (std::uint32_t byte = 0; byte < 256; ++byte) {
      std::uint32_t remainder = byte;
      for (int bit = 0; bit < 8; ++bit) remainder = remainder >> 1U ^ ((remainder & 1U) != 0 ? kReflected : 0U);
      all[0][byte] = remainder;
    }
    for (std::size_t k = 1; k < 8; ++k) {
      for (std::size_t byte = 0; byte < 256; ++byte) {
        const std::uint32_t before = all[k - 1][byte];
        all[k][byte] = before >> 8U ^ all[0][before & 0xFFU];
      }
    }
    return all;
  }
  static const std::array<Table, 8> kTables;

  std::uint32_t crc_ = 0xFFFFFFFF;
};

inline constexpr std::array<Crc32c::Table, 8> Crc32c::kTables = Crc32c::tables();

}  // namespace eha
