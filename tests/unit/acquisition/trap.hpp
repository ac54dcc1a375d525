// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace eha::acquisition {

/// While one of these lives, every allocation, release and lock of its thread is counted (this program's malloc family,
/// operator new and delete on top of it, and pthread_mutex_lock are replaced by ones that count).
class Trap {
 public:
  Trap() noexcept;
  Trap(const Trap&) = delete;
  Trap& operator=(const Trap&) = delete;
  ~Trap();

  [[nodiscard]] static long allocations() noexcept;
  [[nodiscard]] static long locks() noexcept;
  /// False under a sanitizer, which needs the malloc family for itself.
  [[nodiscard]] static bool works() noexcept;
};

}  // namespace eha::acquisition
