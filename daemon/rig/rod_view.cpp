// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rig/rod_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "daemon/acquisition/tick_record.hpp"

namespace eha {
namespace {

using Json = nlohmann::ordered_json;

/// With fewer differences the figure would fluctuate.
constexpr std::size_t kFewestForNoise = 10;

struct LinesOfRig {
  bool emergency_stop;
  bool enable_contact;
};

constexpr const char* kNoNumber = "no reading: the sensor gives no number; eha doctor says more";

Json rod_json(const config::RigLimits& limits, const hal::RigReading& reading, LinesOfRig has, double travel_share) {
  if (!std::isfinite(reading.displacement_in) || !std::isfinite(reading.feedback_V)) {
    return {{"error", kNoNumber}};
  }
  return {{"displacement_in", reading.displacement_in},
          {"feedback_V", reading.feedback_V},
          {"feedback_code", reading.feedback_code},
          {"at_rail", reading.feedback_at_rail},
          {"noise_in", nullptr},
          {"digital_inputs", reading.digital_inputs},
          {"emergency_stop_open", has.emergency_stop ? Json(reading.emergency_stop) : Json(nullptr)},
          {"enable_contact_closed", has.enable_contact ? Json(reading.enable_contact) : Json(nullptr)},
          {"travel_min_in", limits.travel_min_in},
          {"travel_max_in", limits.travel_max_in},
          {"travel_percent", 100.0 * travel_share},
          {"near_limit", travel_share > acquisition::kWarningShare},
          {"error", nullptr}};
}

}  // namespace

double travel_share_at_rest(const config::RigLimits& limits, double displacement_in) noexcept {
  const double middle_in = limits.mid_travel_in();
  return std::abs(displacement_in - middle_in) / (0.5 * (limits.travel_max_in - limits.travel_min_in));
}

void RodView::begin(const hal::RigCapabilities& rig) {
  const std::lock_guard lock(mutex_);
  has_emergency_stop_ = rig.has_emergency_stop;
  has_enable_contact_ = rig.has_enable_contact;
  added_ = 0;
  error_.clear();
}

void RodView::add(const hal::RigReading& reading) {
  const std::lock_guard lock(mutex_);
  last_ = reading;
  read_at_ = std::chrono::steady_clock::now();
  positions_in_[added_++ % kKept] = reading.displacement_in;
  error_.clear();
}

void RodView::moved_to(double displacement_in) {
  const std::lock_guard lock(mutex_);
  if (added_ == 0) return;
  last_.displacement_in = displacement_in;
  read_at_ = std::chrono::steady_clock::now();
  positions_in_[0] = displacement_in;
  added_ = 1;
}

void RodView::fail(hal::RigStatus status) {
  const std::lock_guard lock(mutex_);
  added_ = 0;
  error_ = fmt::format("the rig cannot be read ({}); eha doctor says more", acquisition::to_text(status));
}

Json RodView::describe(const config::RigLimits& limits, std::chrono::steady_clock::time_point now) const {
  const std::lock_guard lock(mutex_);
  if (!error_.empty()) return {{"error", error_}};
  if (added_ == 0) return nullptr;
  const auto age = now - read_at_;
  if (age > kLongestAge) {
    return {
        {"error",
         fmt::format("the rod was not read for {:.0f} s: files are being written, or the card is not open (eha status)",
                     std::chrono::duration<double>(age).count())}};
  }
  Json rod = rod_json(limits, last_, {has_emergency_stop_, has_enable_contact_},
                      travel_share_at_rest(limits, last_.displacement_in));
  if (const auto noise = noise_in(); noise && rod.at("error").is_null()) rod["noise_in"] = *noise;
  return rod;
}

Json RodView::describe(const config::RigLimits& limits, const hal::RigReading& reading, double travel_share) const {
  const std::lock_guard lock(mutex_);
  return rod_json(limits, reading, {has_emergency_stop_, has_enable_contact_}, travel_share);
}

std::optional<double> RodView::noise_in() const {
  const std::size_t count = std::min(added_, kKept);
  if (count < kFewestForNoise) return std::nullopt;
  double sum = 0.0;
  for (std::size_t i = 1; i < count; ++i) {
    const std::size_t newer = (added_ - i) % kKept;
    const std::size_t older = (added_ - i - 1) % kKept;
    const double change = positions_in_[newer] - positions_in_[older];
    sum += change * change;
  }
  if (!std::isfinite(sum)) return std::nullopt;
  return std::sqrt(0.5 * sum / static_cast<double>(count - 1));
}

double place_of(hal::Rig& rig) {
  hal::RigReading reading;
  if (rig.read(0, reading) != hal::RigStatus::ok) throw DeviceError("the rig cannot be read; eha doctor says more");
  if (!std::isfinite(reading.displacement_in)) throw DeviceError(kNoNumber);
  return reading.displacement_in;
}

}  // namespace eha
