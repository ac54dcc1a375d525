// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/reckoned_place.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "config/rig_config.hpp"

namespace eha::track {
namespace {

using acquisition::Fault;

constexpr double kTick_s = 0.001;
constexpr double kStop_in = 5.906;

config::RigLimits limits_of(double gain_in_per_V_s) {
  config::RigLimits limits = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml").limits;
  limits.following->gain_positive_in_per_V_s = 0.5 * gain_in_per_V_s;
  limits.following->gain_negative_in_per_V_s = 0.5 * gain_in_per_V_s;
  return limits;
}

/// A rod that a loop brings along a cycle of 0.6 to 5.3 in as its sensor shows it.
struct Ended {
  Fault fault = Fault::none;
  double at_s = 0.0;
  double rod_in = 0.0;
};

/// @param sensor  what it shows of a rod's place at a time [in]
/// @param gain    of the rod over that of the file
Ended followed(double speed_in_per_s, const std::function<double(double rod_in, double t_s)>& sensor,
               double gain = 1.0) {
  constexpr double kGain = 1.2;
  const config::RigLimits limits = limits_of(kGain);
  const config::ValveEstimate valve = config::valve_estimate(*limits.following);
  ReckonedPlace reckoned(limits, kTick_s);
  const double move_s = 4.7 / speed_in_per_s;
  Ended ended{.rod_in = 0.6};
  double command_V = valve.null_V;
  double last_in = 0.6;
  for (int k = 0; k * kTick_s < 8.0 * (move_s + 0.5); ++k) {
    ended.at_s = k * kTick_s;
    const double shown_in = sensor(ended.rod_in, ended.at_s);
    reckoned.note(shown_in, command_V);
    ended.fault = reckoned.breach().fault;
    if (ended.fault != Fault::none || ended.rod_in > kStop_in || ended.rod_in < 0.0) return ended;
    const double phase_s = std::fmod(ended.at_s, 2.0 * (move_s + 0.5));
    const double up_in = std::min(phase_s, move_s) * speed_in_per_s;
    const double down_in = std::clamp(phase_s - move_s - 0.5, 0.0, move_s) * speed_in_per_s;
    const double wanted_in = 0.6 + up_in - down_in;
    const double speed = (wanted_in - last_in) / kTick_s + 30.0 * (last_in - shown_in);
    last_in = wanted_in;
    command_V = valve.null_V;
    if (std::abs(speed) > 1e-9) command_V += std::copysign(valve.dead_band_V + std::abs(speed) / kGain, speed);
    ended.rod_in += gain * valve.velocity_in_per_s(command_V) * kTick_s;
  }
  return ended;
}

TEST(ReckonedPlace, StopsALoopWhoseSensorsSlopeHasFallenBeforeTheEndStop) {
  for (const double speed : {1.2, 4.0}) {
    for (const double slope : {0.5, 0.72, 0.8}) {
      for (const double from_in : {0.7, 2.0, 3.5}) {
        const Ended ended = followed(speed, [&](double rod_in, double) {
          return rod_in > from_in ? from_in + slope * (rod_in - from_in) : rod_in;
        });
        const bool turns_before = from_in + (5.3 - from_in) / slope < 5.7;
        if (!turns_before) {
          EXPECT_EQ(ended.fault, Fault::wrong_place) << speed << ", " << slope << ", " << from_in;
        }
        EXPECT_LT(ended.rod_in, kStop_in - 0.05) << speed << ", " << slope << ", " << from_in;
      }
    }
  }
}

TEST(ReckonedPlace, StopsALoopWhoseSensorDrifts) {
  for (const double drift : {-0.3, 0.3, -0.6}) {
    const Ended ended =
        followed(1.2, [&](double rod_in, double t_s) { return rod_in + drift * std::max(0.0, t_s - 2.0); });
    EXPECT_EQ(ended.fault, Fault::wrong_place) << drift;
    EXPECT_GT(ended.rod_in, 0.05) << drift;
    EXPECT_LT(ended.rod_in, kStop_in - 0.05) << drift;
  }
}

TEST(ReckonedPlace, LetsASoundRigGoOn) {
  const auto shown = [](double rod_in, double) { return rod_in; };
  for (const double speed : {0.1, 1.2, 4.0}) {
    for (const double gain : {0.9, 1.0, 1.3}) {
      EXPECT_EQ(followed(speed, shown, gain).fault, Fault::none) << speed << ", " << gain;
    }
  }
}

TEST(ReckonedPlace, ReckonsNothingWithoutFollowing) {
  config::RigLimits limits = limits_of(1.2);
  limits.following.reset();
  ReckonedPlace reckoned(limits, kTick_s);
  for (int k = 0; k < 5000; ++k) reckoned.note(3.0, 2.0);
  EXPECT_EQ(reckoned.breach().fault, Fault::none);
}

}  // namespace
}  // namespace eha::track
