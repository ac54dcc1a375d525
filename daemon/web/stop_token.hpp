// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace eha::web {

/// The secret that Stop on the page requires. Thread-safe.
class StopToken {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kShortest = 16;  ///< characters
  static constexpr std::size_t kLongest = 256;
  static constexpr std::size_t kMostWrong = 5;  ///< wrong tries of a user within kWindow; beyond, all are refused
  static constexpr std::chrono::seconds kWindow{10};

  enum class Answer { right, wrong, too_many };

  /// @param text  kShortest to kLongest printable characters without blanks
  /// @throws ConfigError  otherwise, with the length only
  explicit StopToken(std::string text);

  /// Reads the first line of a file that is not readable for others than its owner and group and not writable for its
  /// group.
  /// @throws ConfigError  the content, or the mode   @throws IoError, PermissionError
  [[nodiscard]] static std::string read(const std::filesystem::path& file);

  /// Returns 128 random bits of the kernel in hexadecimal. @throws IoError
  [[nodiscard]] static std::string random();

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

  /// Compares in constant time, and counts a wrong token. After too many wrong tokens of a user refuses even the right
  /// one, so that guessing gets one try in two seconds; other users can still stop.
  /// @param user  at the other end of the connection; none: unknown, which counts as one user
  [[nodiscard]] Answer check(std::string_view text, std::optional<uid_t> user, Clock::time_point now);

 private:
  std::string text_;
  std::mutex mutex_;
  std::map<std::optional<uid_t>, std::deque<Clock::time_point>> wrong_;  ///< tries within kWindow, of each user
};

}  // namespace eha::web
