// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace eha {

/// Place of a journal's next block.
struct JournalPosition {
  std::uint64_t bytes = 0;  ///< size of the file up to the last whole block
  std::uint64_t rows = 0;   ///< rows in its blocks
  std::uint32_t index = 0;  ///< of the next block
};

/// Memory shared by the process that drives a rig and its guard (eha-safe --guard). The loop writes its beats there,
/// and each row until the journal has it. The guard marks that it has acted, and saves the remaining rows if the
/// process dies. An unused page is all zero. Each member has one writer; no call locks or allocates.
/// core/os/shared_memory.hpp maps it.
// NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): members of different writers lie on lines of their own
class GuardPage {
 public:
  static constexpr std::size_t kRowSize = 64;  ///< a TickRecord [bytes]
  /// Exceeds the rows in the queue, the writer's batch and a block together, so that every row not yet in the journal
  /// is here.
  static constexpr std::uint64_t kRows = 16384;

  // ---- The loop's side. Real-time safe.

  /// Begins a run on the monotonic clock: the guard watches the beats until end_drive().
  /// @param thread          of the loop, as gettid() gives it
  /// @param stall_limit_ns  the guard acts after this long without a beat [ns]
  void begin_drive(std::int32_t thread, std::int64_t stall_limit_ns) noexcept {
    loop_thread_.store(thread, std::memory_order_relaxed);
    stall_limit_ns_.store(stall_limit_ns, std::memory_order_relaxed);
    drive_.fetch_add(1, std::memory_order_release);
  }
  void end_drive() noexcept { drive_.fetch_add(1, std::memory_order_release); }
  /// Called once a tick, and after the loop's end before each call to a card that is not confirmed safe: one that does
  /// not answer takes seconds, which the guard would otherwise add up and take for a process that stands still.
  void beat() noexcept { beats_.store(beats_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed); }
  /// Whether the guard has acted in this run: the hydraulics are off.
  [[nodiscard]] bool has_tripped() const noexcept {
    const std::uint32_t drive = drive_.load(std::memory_order_relaxed);
    return is_driven(drive) && tripped_drive_.load(std::memory_order_acquire) == drive;
  }
  /// Stores one row of kRowSize bytes in the page.
  void keep(const void* row) noexcept {
    const std::uint64_t kept = rows_.load(std::memory_order_relaxed);
    std::memcpy(ring_[kept % kRows].data(), row, kRowSize);
    rows_.store(kept + 1, std::memory_order_release);
  }

  // ---- The writer of the journal.

  /// @param path  absolute   @param device, inode  of the open file
  /// @returns false if the path is too long: no row is saved then
  bool begin_journal(const char* path, std::uint64_t device, std::uint64_t inode,
                     const JournalPosition& position) noexcept {
    if (std::strlen(path) >= path_.size()) return false;
    std::strncpy(path_.data(), path, path_.size() - 1);
    device_ = device;
    inode_ = inode;
    rows_.store(0, std::memory_order_relaxed);
    set_position(position);
    has_journal_.store(1, std::memory_order_release);
    return true;
  }
  void set_position(const JournalPosition& position) noexcept {
    // Writes the other slot, then the switch: a writer that is killed in between leaves the old position intact.
    const std::uint32_t next = 1 - slot_.load(std::memory_order_relaxed);
    positions_[next] = position;
    slot_.store(next, std::memory_order_release);
  }
  /// Called when the journal is complete, or can take no more rows.
  void end_journal() noexcept { has_journal_.store(0, std::memory_order_release); }

  // ---- The guard's side.

  /// Changes with each begin_drive() and end_drive().
  [[nodiscard]] std::uint32_t drive() const noexcept { return drive_.load(std::memory_order_acquire); }
  [[nodiscard]] static bool is_driven(std::uint32_t drive) noexcept { return drive % 2 == 1; }
  [[nodiscard]] std::uint64_t beats() const noexcept { return beats_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int32_t loop_thread() const noexcept { return loop_thread_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t stall_limit_ns() const noexcept { return stall_limit_ns_.load(std::memory_order_relaxed); }
  /// @param drive  the run that the guard acted in
  void trip(std::uint32_t drive) noexcept { tripped_drive_.store(drive, std::memory_order_release); }

  // For use after the death of the driving process.

  [[nodiscard]] bool has_journal() const noexcept { return has_journal_.load(std::memory_order_acquire) == 1; }
  [[nodiscard]] const char* journal_path() const noexcept { return path_.data(); }
  [[nodiscard]] std::uint64_t journal_device() const noexcept { return device_; }
  [[nodiscard]] std::uint64_t journal_inode() const noexcept { return inode_; }
  [[nodiscard]] JournalPosition position() const noexcept {
    return positions_[slot_.load(std::memory_order_acquire) % positions_.size()];
  }
  /// Number of rows of the run; the last kRows of them are in the page.
  [[nodiscard]] std::uint64_t rows() const noexcept { return rows_.load(std::memory_order_acquire); }
  [[nodiscard]] const std::byte* row(std::uint64_t number) const noexcept { return ring_[number % kRows].data(); }

  /// Version of the layout; the guard does not use a page of another one.
  static constexpr std::uint64_t kVersion = 0x4548'4150'4147'4531;  // "EHAPAGE1"
  void mark_version() noexcept { version_ = kVersion; }
  [[nodiscard]] bool is_of_this_version() const noexcept { return version_ == kVersion; }

 private:
  static constexpr std::size_t kCacheLine = 64;
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uint32_t>::is_always_lock_free);

  std::uint64_t version_ = 0;
  // Written by the loop in each tick.
  alignas(kCacheLine) std::atomic<std::uint64_t> beats_{0};
  std::atomic<std::uint64_t> rows_{0};
  // Written by the loop at a run's begin and end.
  alignas(kCacheLine) std::atomic<std::uint32_t> drive_{0};
  std::atomic<std::int32_t> loop_thread_{0};
  std::atomic<std::int64_t> stall_limit_ns_{0};
  // Written by the guard.
  alignas(kCacheLine) std::atomic<std::uint32_t> tripped_drive_{0};
  // Written by the writer of the journal.
  alignas(kCacheLine) std::atomic<std::uint32_t> has_journal_{0};
  std::atomic<std::uint32_t> slot_{0};
  std::array<JournalPosition, 2> positions_{};
  std::uint64_t device_ = 0;
  std::uint64_t inode_ = 0;
  std::array<char, 4096> path_{};
  alignas(kCacheLine) std::array<std::array<std::byte, kRowSize>, kRows> ring_{};
};

}  // namespace eha
