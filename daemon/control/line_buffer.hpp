// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace eha::control {

/// Splits a stream of bytes into lines of bounded length. Memory: one longest line plus the bytes of one append().
/// Cost: each byte is scanned once. Not thread-safe.
class LineBuffer {
 public:
  /// @param longest  of a line, its newline not counted [bytes]
  explicit LineBuffer(std::size_t longest) : longest_(longest) {}

  void append(std::string_view bytes);

  /// Takes the next whole line without its newline (and a carriage return before it); none if it is incomplete.
  [[nodiscard]] std::optional<std::string> next_line();

  /// Whether the next line is whole.
  [[nodiscard]] bool has_line() const noexcept { return bytes_.find('\n', scanned_) != std::string::npos; }

  /// Whether the first line is longer than allowed; the rest of the stream is then unusable.
  [[nodiscard]] bool is_too_long() const noexcept;

  /// Number of bytes in lines that are incomplete or not taken.
  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size() - begin_; }

 private:
  std::size_t longest_;
  std::string bytes_;
  std::size_t begin_ = 0;    ///< of the line at the front
  std::size_t scanned_ = 0;  ///< no newline in [begin_, scanned_)
};

}  // namespace eha::control
