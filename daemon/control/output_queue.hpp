// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace eha::control {

/// Text that waits to be sent to a client, in parts. A part may be shared with other clients: a list of all runs has
/// megabytes, and several clients may wait for it at once. Cost of each call: independent of the size. Not thread-safe.
class OutputQueue {
 public:
  using Part = std::shared_ptr<const std::string>;

  void add(Part part) {
    if (part->empty()) return;
    size_ += part->size();
    parts_.push_back(std::move(part));
  }
  void add(std::string text) { add(std::make_shared<const std::string>(std::move(text))); }

  [[nodiscard]] bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

  /// What is to be sent next. Must not be empty.
  [[nodiscard]] std::string_view front() const { return std::string_view(*parts_.front()).substr(sent_); }
  /// Removes what was sent of front().
  void take(std::size_t count) {
    size_ -= count;
    sent_ += count;
    if (sent_ < parts_.front()->size()) return;
    parts_.pop_front();
    sent_ = 0;
  }

  void clear() noexcept {
    parts_.clear();
    size_ = 0;
    sent_ = 0;
  }

 private:
  std::deque<Part> parts_;
  std::size_t size_ = 0;
  std::size_t sent_ = 0;  ///< of the first part
};

}  // namespace eha::control
