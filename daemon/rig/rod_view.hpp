// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "config/rig_config.hpp"
#include "hal/rig.hpp"

namespace eha {

/// Displayed readings of an undriven rig: the last one, and the sensor's noise over the last kKept. Thread-safe: one
/// thread reads the rig and adds, any thread may ask.
class RodView {
 public:
  static constexpr std::size_t kKept = 50;
  static constexpr std::chrono::seconds kLongestAge{2};  ///< of a reading that is shown as the rod's place

  /// Resets the view for a newly opened rig.
  void begin(const hal::RigCapabilities& rig);
  void add(const hal::RigReading& reading);
  /// Replaces the place of the last reading, and forgets the earlier ones: a run has moved the rod there.
  void moved_to(double displacement_in);
  /// Reports that the rig could not be read.
  void fail(hal::RigStatus status);

  /// Returns the member `rod` of ehad-protocol(7) from the last reading; null before the first, an error where that is
  /// older than kLongestAge.
  [[nodiscard]] nlohmann::ordered_json describe(
      const config::RigLimits& limits,
      std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now()) const;

  /// The same from a reading during a run, without the noise.
  /// @param travel_share  of the run, stopping distance included; see LimitMonitor
  [[nodiscard]] nlohmann::ordered_json describe(const config::RigLimits& limits, const hal::RigReading& reading,
                                                double travel_share) const;

 private:
  /// From successive differences, so that a creeping rod adds nothing (von Neumann, Ann. Math. Statist. 12, 1941).
  [[nodiscard]] std::optional<double> noise_in() const;

  mutable std::mutex mutex_;
  bool has_emergency_stop_ = false;
  bool has_enable_contact_ = false;
  hal::RigReading last_;
  std::chrono::steady_clock::time_point read_at_{};
  std::array<double, kKept> positions_in_{};
  std::size_t added_ = 0;
  std::string error_;  ///< empty: the last reading succeeded
};

/// Reads where the rod of an open rig that is not driven stands [in].
/// @throws DeviceError  the rig cannot be read, or the sensor gives no number
[[nodiscard]] double place_of(hal::Rig& rig);

/// Returns the share of the way from mid-travel to a travel limit for a rod at rest; over 1 beyond the limit.
[[nodiscard]] double travel_share_at_rest(const config::RigLimits& limits, double displacement_in) noexcept;

}  // namespace eha
