// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstddef>

#include "daemon/acquisition/tick_record.hpp"

namespace eha::acquisition {

/// Carries tick records from the loop (the only producer) to the writer (the only consumer). Real-time safe.
class RecordQueue {
 public:
  static constexpr std::size_t kCapacity = 8192;                 ///< 8 s at 1 kHz
  static constexpr std::size_t kNearlyFull = kCapacity / 4 * 3;  ///< fill at which the loop ramps out

  /// Producer. @returns false when full: the record is lost and the run has failed
  [[nodiscard]] bool push(const TickRecord& record) noexcept { return queue_.push(record); }
  /// Producer.
  [[nodiscard]] std::size_t fill() const noexcept { return kCapacity - queue_.write_available(); }

  /// Consumer. @returns the number of records written to `records`
  std::size_t pop(TickRecord* records, std::size_t count) noexcept { return queue_.pop(records, count); }

  /// Consumer: the writer can keep no more records; the loop ramps out.
  void report_writer_failure() noexcept { writer_failed_.store(true, std::memory_order_release); }
  [[nodiscard]] bool writer_failed() const noexcept { return writer_failed_.load(std::memory_order_acquire); }

 private:
  boost::lockfree::spsc_queue<TickRecord, boost::lockfree::capacity<kCapacity>> queue_;
  std::atomic<bool> writer_failed_{false};
};

}  // namespace eha::acquisition
