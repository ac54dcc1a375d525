// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/record/experiment_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"

namespace eha::record {
namespace {

/// Ticks of an experiment that may have left no row, some 17 minutes at 1 kHz: a loop that stands still for a second
/// has tripped, and rows that were lost from a journal are marked.
constexpr std::uint64_t kMostMissing = 1'000'000;

}  // namespace

void ExperimentRows::add(std::span<const acquisition::TickRecord> ticks) {
  for (const acquisition::TickRecord& tick : ticks) {
    if (tick.state != acquisition::State::running) continue;
    if (!has_first_) first_sequence_ = tick.sequence;
    has_first_ = true;
    const std::uint64_t due = std::uint64_t{first_sequence_} + next_row_;
    require_next(tick.sequence, due);
    missing_ += tick.sequence - due;
    const std::size_t row = tick.sequence - first_sequence_;
    while (next_row_ < row) {
      add_unmeasured(last_V_);
      if (without_V_ > 0) ++without_V_;
    }
    if ((tick.flags & acquisition::kLost) != 0) {
      add_unmeasured(tick.applied_V);
      ++without_V_;
      ++lost_;
      continue;
    }
    learn_voltage(tick.applied_V);
    const bool is_measured =
        (tick.flags & (acquisition::kSkipped | acquisition::kFeedbackHeld)) == 0 && std::isfinite(tick.displacement_in);
    if (is_measured) {
      add_measured(tick.applied_V, tick.displacement_in);
    } else {
      add_unmeasured(tick.applied_V);
    }
  }
}

void ExperimentRows::require_next(std::uint64_t sequence, std::uint64_t due) const {
  if (sequence < due) {
    throw DataError(
        fmt::format("{}: tick {} comes after tick {}: damaged; play the experiment again", source_, sequence, due - 1));
  }
  if (sequence - due > kMostMissing - missing_) {
    throw DataError(
        fmt::format("{}: tick {} comes after tick {}, so that more than {} ticks have no row: damaged; play the "
                    "experiment again",
                    source_, sequence, due - 1, kMostMissing));
  }
}

void ExperimentRows::finish() {
  learn_voltage(last_V_);
  if (has_measured_) release(last_in_);
}

void ExperimentRows::add_measured(double voltage_V, double displacement_in) {
  if (!has_measured_) last_in_ = displacement_in;
  has_measured_ = true;
  release(displacement_in);
  emit_(next_row_++, voltage_V, displacement_in);
  last_in_ = displacement_in;
}

void ExperimentRows::add_unmeasured(double voltage_V) {
  waiting_V_.push_back(voltage_V);
  interpolated_.push_back(next_row_++);
}

void ExperimentRows::learn_voltage(double voltage_V) {
  const std::size_t first = waiting_V_.size() - without_V_;
  for (std::size_t i = 0; i < without_V_; ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(without_V_ + 1);
    waiting_V_[first + i] = last_V_ + share * (voltage_V - last_V_);
  }
  without_V_ = 0;
  last_V_ = voltage_V;
}

void ExperimentRows::release(double until_in) {
  const std::size_t count = waiting_V_.size();
  const std::size_t first = next_row_ - count;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i + 1) / static_cast<double>(count + 1);
    emit_(first + i, waiting_V_[i], last_in_ + share * (until_in - last_in_));
  }
  waiting_V_.clear();
}

}  // namespace eha::record
