// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#include "daemon/acquisition/clock.hpp"
#include "daemon/acquisition/command_source.hpp"

namespace eha::play {

/// Judges the repetition after which a run may end. note() belongs to the thread that plays; the other members may be
/// called from any thread and are real-time safe.
class EarlyEnd {
 public:
  EarlyEnd() = default;
  EarlyEnd(const EarlyEnd&) = delete;
  EarlyEnd& operator=(const EarlyEnd&) = delete;
  virtual ~EarlyEnd() = default;

  /// Called about ten times a second while the run lasts. Returns at once and throws nothing.
  /// @param repetitions  complete ones in the journal
  virtual void note(int repetitions) = 0;

  /// Whether the run may end after the present repetition.
  [[nodiscard]] bool is_reached() const noexcept { return is_reached_.load(std::memory_order_acquire); }
  /// Returns the number of judged repetitions; the greatest int if no more are judged.
  [[nodiscard]] int judged() const noexcept { return judged_.load(std::memory_order_acquire); }

  /// Ends the judging: every repetition is played.
  void give_up() noexcept { judged_.store(std::numeric_limits<int>::max(), std::memory_order_release); }

 protected:
  std::atomic<bool> is_reached_{false};
  std::atomic<int> judged_{0};
};

/// A source that ends after the repetition in which an EarlyEnd is reached. In virtual time the end of a repetition
/// waits until the one before has been judged, as it would be by then on the monotonic clock. Real-time safe on the
/// monotonic clock.
class EarlyEndSource final : public acquisition::CommandSource {
 public:
  /// @param judge  must outlive this
  EarlyEndSource(std::unique_ptr<acquisition::CommandSource> source, const EarlyEnd& judge,
                 acquisition::TimeBase time_base)
      : source_(std::move(source)), judge_(judge), waits_(time_base == acquisition::TimeBase::virtual_time) {}

  [[nodiscard]] Stage stage() const noexcept override {
    const Stage stage = source_->stage();
    if (stage != Stage::playing || next_row_ == 0 || next_row_ >= rows() || next_row_ % rows_per_repetition() != 0) {
      return stage;
    }
    const auto played = static_cast<int>(next_row_ / rows_per_repetition());
    while (waits_ && judge_.judged() < played - 1) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return judge_.is_reached() ? Stage::over : stage;
  }
  [[nodiscard]] bool brings_back() const noexcept override { return source_->brings_back(); }
  [[nodiscard]] acquisition::Breach breach() const noexcept override { return source_->breach(); }
  void go_on_from(const acquisition::LackingWay& lacking) noexcept override { source_->go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return source_->lacking(); }
  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_->rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_->rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    // Row 0 is also requested before the first tick that plays it.
    next_row_ = row + 1;
    return source_->voltage_V(row, last);
  }

  /// After the run: whether the judge ended it before its last row.
  [[nodiscard]] bool ended_early() const noexcept {
    return judge_.is_reached() && next_row_ > 0 && next_row_ < rows() && next_row_ % rows_per_repetition() == 0;
  }

 private:
  std::unique_ptr<acquisition::CommandSource> source_;
  const EarlyEnd& judge_;
  bool waits_;
  std::uint32_t next_row_ = 0;
};

}  // namespace eha::play
