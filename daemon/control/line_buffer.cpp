// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/control/line_buffer.hpp"

namespace eha::control {

void LineBuffer::append(std::string_view bytes) {
  if (begin_ > 0) {
    bytes_.erase(0, begin_);
    scanned_ -= begin_;
    begin_ = 0;
  }
  bytes_.append(bytes);
}

std::optional<std::string> LineBuffer::next_line() {
  const std::size_t end = bytes_.find('\n', scanned_);
  if (end == std::string::npos) {
    scanned_ = bytes_.size();
    return std::nullopt;
  }
  if (end - begin_ > longest_) return std::nullopt;
  std::string line = bytes_.substr(begin_, end - begin_);
  if (!line.empty() && line.back() == '\r') line.pop_back();
  begin_ = end + 1;
  scanned_ = begin_;
  return line;
}

bool LineBuffer::is_too_long() const noexcept {
  if (size() <= longest_) return false;
  const std::size_t end = bytes_.find('\n', scanned_);
  return (end == std::string::npos ? bytes_.size() : end) - begin_ > longest_;
}

}  // namespace eha::control
