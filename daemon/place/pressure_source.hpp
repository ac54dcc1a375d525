// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "config/rig_config.hpp"
#include "daemon/acquisition/command_source.hpp"

namespace eha::place {

/// Keeps the valve at its null until the pressure has built up, then plays another source: while missing motion does
/// not count, the following check finds no sensor that fails. Real-time safe. Not thread-safe.
class PressureSource final : public acquisition::CommandSource {
 public:
  PressureSource(const config::Following& following, double period_s,
                 std::unique_ptr<acquisition::CommandSource> source) noexcept
      : null_V_(following.null_V),
        delay_s_(following.pressure_delay_s),
        period_s_(period_s),
        source_(std::move(source)) {}

  [[nodiscard]] bool brings_back() const noexcept override { return source_->brings_back(); }
  void go_on_from(const acquisition::LackingWay& lacking) noexcept override { source_->go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return source_->lacking(); }
  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_->rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_->rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    has_begun_ = elapsed_s_ >= delay_s_;
    if (has_begun_) return source_->voltage_V(row, last);
    elapsed_s_ += period_s_;
    return null_V_;
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_->stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    return has_begun_ ? source_->breach() : acquisition::Breach{};
  }

 private:
  double null_V_;
  double delay_s_;
  double period_s_;
  std::unique_ptr<acquisition::CommandSource> source_;
  double elapsed_s_ = 0.0;
  bool has_begun_ = false;  ///< the source was asked for its row 0, so that the ramp leads there
};

}  // namespace eha::place
