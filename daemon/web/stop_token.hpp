// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>

namespace eha::web {

/// The secret that Stop on the page asks for. Thread-safe.
class StopToken {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kShortest = 16;  ///< characters
  static constexpr std::size_t kLongest = 256;
  static constexpr std::size_t kMostWrong = 5;  ///< within kWindow; then every try is refused until one is older
  static constexpr std::chrono::seconds kWindow{10};

  enum class Answer { right, wrong, too_many };

  /// @param text  kShortest to kLongest printable characters without blanks
  /// @throws ConfigError  otherwise, with the length only
  explicit StopToken(std::string text);

  /// The first line of a file that others than its owner and group cannot read and that its group cannot write.
  /// @throws ConfigError  the content, or the mode   @throws IoError, PermissionError
  [[nodiscard]] static std::string read(const std::filesystem::path& file);

  /// 128 random bits of the kernel in hexadecimal. @throws IoError
  [[nodiscard]] static std::string random();

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

  /// Compares in a time that does not depend on where they differ, and counts a wrong one. A right token is refused too
  /// while there were too many wrong ones, so that guessing gains one try in two seconds.
  [[nodiscard]] Answer check(std::string_view text, Clock::time_point now);

 private:
  std::string text_;
  std::mutex mutex_;
  std::deque<Clock::time_point> wrong_;
};

}  // namespace eha::web
