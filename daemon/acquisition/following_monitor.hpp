// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "config/rig_config.hpp"
#include "daemon/acquisition/limit_monitor.hpp"

namespace eha::acquisition {

/// Without [following]: volts further from 0 V must move the rod [V].
inline constexpr double kFallbackDeadBand_V = 0.75;

/// The numbers that the following check works with. Index 0 is the direction of greater displacement, d = +1; index 1
/// the other one, d = -1.
struct FollowingRule {
  std::array<double, 2> least_gain_in_per_V_s{};     ///< the rod moves at least so fast for each volt outside the band
  std::array<double, 2> greatest_gain_in_per_V_s{};  ///< and at most so fast
  double null_V = 0.0;                               ///< middle of the valve's dead band [V]
  double dead_band_V = 0.0;                          ///< its half width [V]
  double early_V = 0.0;                     ///< the rod may begin to move this far on the other side of the null [V]
  std::array<double, 2> waiting_early_V{};  ///< the same until the pressure has built up, at most early_V [V]
  double missing_limit_in = 0.0;            ///< [in]
  double excess_limit_in = 0.0;             ///< [in]
  double pressure_delay_s = 0.0;            ///< from enable on to full pressure [s]
};

/// The rule of a rig's [following], whose gains are half of the measured ones: the greatest is twice the least. Without
/// [following] the rule is one that every valve of a rig with these limits should satisfy; it detects less. The
/// greatest gain reaches the velocity limit at half the command range, the least is 1/32 of it, the dead band
/// kFallbackDeadBand_V about 0 V.
[[nodiscard]] FollowingRule following_rule(const config::RigLimits& limits) noexcept;

/// Motion that the commands of earlier runs asked for and the sensor did not show, of each direction [in]. Without it a
/// series of runs, each too short to show that the sensor is dead, would carry the rod to its end stop.
using MissingMotion = std::array<double, 2>;

/// Compares the sensor's motion with the least and the greatest motion that the commands cause. Detects a sensor that
/// is stuck, open or reversed even if its code never rests. With u and y through the same low-pass filter (time
/// constant 0.05 s), for each direction d, at each reading, dt and dy since the one before:
///   e = d (u - null) - dead_band;   S_d = max(0, S_d + g_d e dt - d dy) where e > 0, else S_d stays
///   X_d = max(0, X_d + d dy - G_d max(0, d (u - null) + early) dt)
/// While the pressure builds up the command stands at the null, and early is what the null's uncertainty, or a rod that
/// sags at 0.05 in/s, needs: a null that is wrong shows by the rod's drift. not_following at S_d > missing limit,
/// unexplained_motion at X_d > excess limit; g is the least and G the greatest gain. The sensor's noise telescopes in
/// the sum of dy, so noise alone never counts as motion. The sums start at begin(), S_d when the pressure has built up,
/// from what the runs before have left missing. A run leaves R_d, which is S_d but that the motion of the 0.5 s after
/// the command counts, too, unless it is commanded the other way then: of a rod that lags nothing is left. Motion
/// against d in that time, as of a rod that creeps, adds nothing: R_d is at most the limit. Does not detect a slope
/// error within the range of the gains, or a drift slower than the valve's own. Real-time safe; cost: some twenty
/// operations. Not thread-safe.
class FollowingMonitor {
 public:
  explicit FollowingMonitor(const FollowingRule& rule, const MissingMotion& earlier = {}) noexcept
      : rule_(rule), missing_in_(earlier), left_in_(earlier) {}

  /// The hydraulics go on. @param at_ns  as in check()
  void begin(std::int64_t at_ns) noexcept;

  /// @param at_ns            time of the reading from the run's start, increasing [ns]
  /// @param displacement_in  finite [in]
  /// @param applied_V        the voltage held since the reading before [V]
  [[nodiscard]] Breach check(std::int64_t at_ns, double displacement_in, double applied_V) noexcept;

  /// The greatest S and X so far, as shares of their limits.
  [[nodiscard]] double peak_missing() const noexcept { return peak_missing_; }
  [[nodiscard]] double peak_excess() const noexcept { return peak_excess_; }

  /// What this run leaves to the next one.
  [[nodiscard]] const MissingMotion& left_in() const noexcept { return left_in_; }

 private:
  FollowingRule rule_;
  bool has_reading_ = false;
  bool has_begun_ = false;
  std::int64_t last_ns_ = 0;
  std::int64_t pressure_ns_ = 0;  ///< time from which missing motion counts
  double filtered_V_ = 0.0;
  double filtered_in_ = 0.0;
  MissingMotion missing_in_;
  MissingMotion left_in_;
  std::array<double, 2> rests_s_{1.0, 1.0};  ///< since a direction was commanded
  MissingMotion unmoved_in_{};               ///< R_d then
  std::array<double, 2> rests_at_in_{};      ///< the rod then, filtered [in]
  std::array<double, 2> excess_in_{};
  double peak_missing_ = 0.0;
  double peak_excess_ = 0.0;
};

}  // namespace eha::acquisition
