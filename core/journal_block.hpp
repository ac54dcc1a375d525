// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

// The blocks of a journal (raw.ehalog), for the program that writes one and the guard that completes it;
// daemon/record/journal.hpp describes the file.

namespace eha::journal {

inline constexpr std::string_view kBlockTag = "EHAB";
inline constexpr std::string_view kEndTag = "EHAE";
inline constexpr std::size_t kBlockHeaderSize = 16;
inline constexpr std::uint32_t kMostRecordsPerBlock = 1u << 14;  ///< a block is 0.1 s or less: 1000 records at 0.1 ms

inline constexpr std::uint32_t kLongestEnd = 1u << 16;  ///< [bytes]; an end has some hundred

/// CRC-32C (Castagnoli), as in iSCSI, RFC 3720.
class Crc32c {
 public:
  Crc32c& add(const void* data, std::size_t size) {
    crc_.process_bytes(data, size);
    return *this;
  }
  [[nodiscard]] std::uint32_t value() const { return static_cast<std::uint32_t>(crc_.checksum()); }

 private:
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc_;
};

inline void append_u32(std::string& text, std::uint32_t value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  text.append(bytes.data(), bytes.size());
}

[[nodiscard]] inline std::uint32_t u32_at(const char* bytes) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

/// Appends tag, count, index, CRC over count, index and payload, and the payload.
inline void append_block(std::string& text, std::string_view tag, std::uint32_t count, std::uint32_t index,
                         std::string_view payload) {
  text.append(tag);
  const std::size_t covered = text.size();
  append_u32(text, count);
  append_u32(text, index);
  append_u32(text, Crc32c().add(text.data() + covered, 8).add(payload.data(), payload.size()).value());
  text.append(payload);
}

}  // namespace eha::journal
