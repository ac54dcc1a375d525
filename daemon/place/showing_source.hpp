// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "config/measured_check.hpp"
#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/loop_monitor.hpp"
#include "daemon/place/place_controller.hpp"

namespace eha::place {

/// Places the rod a little towards mid-travel and half-way back before another source begins, in its row 0. The bounds
/// of a placing find a sensor that is dead, and gains or a null of [following] that are not the rod's, at its speed;
/// the volts of the other source may be far from that where the rod already stands at its start. Real-time safe. Not
/// thread-safe.
class ShowingSource final : public acquisition::CommandSource {
 public:
  /// @param limits  must outlive this
  ShowingSource(const config::RigLimits& limits, double period_s,
                std::unique_ptr<acquisition::CommandSource> source) noexcept
      : limits_(limits),
        bounds_(loop_bounds(limits)),
        period_s_(period_s),
        rest_s_(kRest_s + 2.0 * bounds_.edge_V / limits.slew_V_per_s),
        source_(std::move(source)) {}

  void go_on_from(const acquisition::LackingWay& lacking) noexcept override { source_->go_on_from(lacking); }
  [[nodiscard]] const acquisition::LackingWay* lacking() const noexcept override { return source_->lacking(); }
  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_->rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_->rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    if (!way_) begin(last.displacement_in);
    if (has_begun_) return source_->voltage_V(row, last);
    elapsed_s_ += period_s_;
    if (!is_resting_) {
      const double command_V = way_->voltage_V(last);
      is_resting_ = way_->is_in_place();
      if (is_resting_) elapsed_s_ = 0.0;
      return command_V;
    }
    if (elapsed_s_ < rest_s_) return bounds_.null_V;
    if (is_on_way_back_) {
      has_begun_ = true;
      return source_->voltage_V(row, last);
    }
    is_on_way_back_ = true;
    move_to(back_in_);
    return bounds_.null_V;
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_->stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (has_begun_) return source_->breach();
    if (!way_ || is_resting_) return {};
    if (way_->breach().fault != acquisition::Fault::none) return way_->breach();
    return elapsed_s_ > placing_time_s(limits_, way_->way_in()) ? way_->failure() : acquisition::Breach{};
  }

 private:
  static constexpr double kRest_s = 0.1;

  void begin(double place_in) noexcept {
    const double way_in = config::showing_way_in(limits_, place_in);
    back_in_ = place_in + config::kShowingLeaves * way_in;
    move_to(place_in + way_in);
  }
  void move_to(double place_in) noexcept {
    way_.emplace(limits_, period_s_, place_in);
    is_resting_ = false;
    elapsed_s_ = 0.0;
  }

  const config::RigLimits& limits_;
  LoopBounds bounds_;
  double period_s_;
  double rest_s_;  ///< at the null after each way, where a placing takes the command to be when it begins
  std::unique_ptr<acquisition::CommandSource> source_;
  std::optional<PlaceController> way_;
  double back_in_ = 0.0;
  double elapsed_s_ = 0.0;
  bool is_resting_ = false;
  bool is_on_way_back_ = false;
  bool has_begun_ = false;  ///< the source was asked for its row 0, so that the ramp leads there
};

}  // namespace eha::place
