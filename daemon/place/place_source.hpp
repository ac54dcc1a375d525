// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/place_controller.hpp"

namespace eha::place {

/// Where a placing may begin.
enum class Begin {
  within_limits,
  anywhere,  ///< also beyond a travel limit: inward only
};

/// A run that moves the rod to a place: over once it is there, a fault when its rows are used up before.
class PlaceSource final : public acquisition::CommandSource {
 public:
  /// @param rows  the time-out [ticks]
  PlaceSource(const PlaceController& controller, std::uint32_t rows, Begin begin = Begin::within_limits) noexcept
      : controller_(controller), rows_(rows), begin_(begin) {}

  [[nodiscard]] bool brings_back() const noexcept override { return begin_ == Begin::anywhere; }
  void go_on_from(const acquisition::LackingWay& lacking) noexcept override { controller_.go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return &controller_.lacking(); }

  [[nodiscard]] std::uint32_t rows() const noexcept override { return rows_; }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return rows_; }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    row_ = row;
    return controller_.voltage_V(last);
  }
  [[nodiscard]] Stage stage() const noexcept override {
    return controller_.is_in_place() ? Stage::over : Stage::playing;
  }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (controller_.breach().fault != acquisition::Fault::none) return controller_.breach();
    if (row_ + 1 < rows_ || controller_.is_in_place()) return {};
    return controller_.failure();
  }

 private:
  PlaceController controller_;
  std::uint32_t rows_;
  Begin begin_;
  std::uint32_t row_ = 0;
};

/// Moves the rod to a place before another source begins: in its row 0, which the tick asks for until the source is
/// ready.
class StartingSource final : public acquisition::CommandSource {
 public:
  /// @param limits  must outlive this
  StartingSource(const PlaceController& controller, const config::RigLimits& limits, double period_s,
                 std::unique_ptr<acquisition::CommandSource> source) noexcept
      : controller_(controller), limits_(limits), period_s_(period_s), source_(std::move(source)) {}

  void go_on_from(const acquisition::LackingWay& lacking) noexcept override { controller_.go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return &controller_.lacking(); }
  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_->rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_->rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    if (controller_.is_in_place()) {
      has_begun_ = true;
      return source_->voltage_V(row, last);
    }
    elapsed_s_ += period_s_;
    return controller_.voltage_V(last);
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_->stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (controller_.is_in_place()) return source_->breach();
    if (controller_.breach().fault != acquisition::Fault::none) return controller_.breach();
    return elapsed_s_ > placing_time_s(limits_, controller_.way_in()) ? controller_.failure() : acquisition::Breach{};
  }

 private:
  PlaceController controller_;
  const config::RigLimits& limits_;
  double period_s_;
  std::unique_ptr<acquisition::CommandSource> source_;
  double elapsed_s_ = 0.0;
  bool has_begun_ = false;  ///< the source was asked for its row 0, so that the ramp leads there
};

}  // namespace eha::place
