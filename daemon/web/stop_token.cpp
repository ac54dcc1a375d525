// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/web/stop_token.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"

namespace eha::web {

StopToken::StopToken(std::string text) : text_(std::move(text)) {
  const auto is_printable = [](char c) { return c > ' ' && c <= '~'; };
  if (text_.size() < kShortest || text_.size() > kLongest || !std::all_of(text_.begin(), text_.end(), is_printable)) {
    throw ConfigError(
        fmt::format("the token has {} characters; expected {} to {} printable ones without blanks, such as those of "
                    "`openssl rand -hex 16`",
                    text_.size(), kShortest, kLongest));
  }
}

std::string StopToken::read(const std::filesystem::path& file) {
  const os::FileDescriptor opened = os::open_file(file, O_RDONLY | O_NONBLOCK);
  struct stat status {};
  if (fstat(opened.get(), &status) != 0) os::throw_system_error("look at", file, errno);
  if (!S_ISREG(status.st_mode)) throw ConfigError(file.string() + ": not a regular file");
  if ((status.st_mode & 0027) != 0) {
    throw ConfigError(
        fmt::format("{}: its mode is {:04o}, so others may read it or its group may change it; expected "
                    "0640 or less: chmod 0640 {}",
                    file.string(), status.st_mode & 07777, file.string()));
  }
  std::string text(kLongest + 2, '\0');
  text.resize(os::read_up_to(opened, text.data(), text.size(), file));
  text.resize(std::min(text.find_first_of("\r\n"), text.size()));
  return text;
}

std::string StopToken::random() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw IoError("cannot get random bytes: " + error_text(errno));
  }
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

StopToken::Answer StopToken::check(std::string_view text, std::optional<uid_t> user, Clock::time_point now) {
  const std::lock_guard lock(mutex_);
  for (auto& [of, tries] : wrong_) {
    while (!tries.empty() && now - tries.front() >= kWindow) tries.pop_front();
  }
  std::erase_if(wrong_, [](const auto& item) { return item.second.empty(); });
  const auto tried = wrong_.find(user);
  if (tried != wrong_.end() && tried->second.size() >= kMostWrong) return Answer::too_many;
  // Another length is compared with the token itself, so that it takes as long.
  const bool has_length = text.size() == text_.size();
  const char* compared = has_length ? text.data() : text_.data();
  if (CRYPTO_memcmp(compared, text_.data(), text_.size()) == 0 && has_length) return Answer::right;
  wrong_[user].push_back(now);
  return Answer::wrong;
}

}  // namespace eha::web
