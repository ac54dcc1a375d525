// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "daemon/acquisition/command_source.hpp"
#include "daemon/place/place_controller.hpp"

namespace eha::place {

inline constexpr double kShowing_in = 0.3;  ///< at most, of the way there

/// Places the rod a little towards mid-travel and back before another source begins, in its row 0. The bounds of a
/// placing find a sensor that is dead, and gains or a null of [following] that are not the rod's, at its speed; the
/// volts of the other source may be far from that where the rod already stands at its start. Real-time safe. Not
/// thread-safe.
class ShowingSource final : public acquisition::CommandSource {
 public:
  /// @param limits  must outlive this
  ShowingSource(const config::RigLimits& limits, double period_s,
                std::unique_ptr<acquisition::CommandSource> source) noexcept
      : limits_(limits), period_s_(period_s), source_(std::move(source)) {}

  [[nodiscard]] std::uint32_t rows() const noexcept override { return source_->rows(); }
  [[nodiscard]] std::uint32_t rows_per_repetition() const noexcept override { return source_->rows_per_repetition(); }
  [[nodiscard]] double voltage_V(std::uint32_t row, const hal::RigReading& last) noexcept override {
    if (!way_) begin(last.displacement_in);
    if (way_->is_in_place() && !is_on_way_back_) {
      is_on_way_back_ = true;
      move_to(from_in_);
    }
    has_begun_ = way_->is_in_place();
    if (has_begun_) return source_->voltage_V(row, last);
    elapsed_s_ += period_s_;
    return way_->voltage_V(last);
  }
  [[nodiscard]] Stage stage() const noexcept override { return has_begun_ ? source_->stage() : Stage::preparing; }
  [[nodiscard]] acquisition::Breach breach() const noexcept override {
    if (!way_) return {};
    if (way_->is_in_place()) return has_begun_ ? source_->breach() : acquisition::Breach{};
    if (way_->breach().fault != acquisition::Fault::none) return way_->breach();
    return elapsed_s_ > placing_time_s(limits_, way_->way_in()) ? way_->failure() : acquisition::Breach{};
  }

 private:
  static constexpr double kMostOfTravel = 0.1;

  void begin(double place_in) noexcept {
    from_in_ = place_in;
    const double travel_in = limits_.travel_max_in - limits_.travel_min_in;
    const double to_middle_in = limits_.travel_min_in + 0.5 * travel_in - place_in;
    move_to(place_in + std::copysign(std::min(kShowing_in, kMostOfTravel * travel_in), to_middle_in));
  }
  void move_to(double place_in) noexcept {
    way_.emplace(limits_, period_s_, place_in);
    elapsed_s_ = 0.0;
  }

  const config::RigLimits& limits_;
  double period_s_;
  std::unique_ptr<acquisition::CommandSource> source_;
  std::optional<PlaceController> way_;
  double from_in_ = 0.0;
  double elapsed_s_ = 0.0;
  bool is_on_way_back_ = false;
  bool has_begun_ = false;  ///< the source was asked for its row 0, so that the ramp leads there
};

}  // namespace eha::place
