// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "hal/sim/sim_rig.hpp"

namespace eha::replay::test {

struct TwinRecord {
  Eigen::VectorXd volts;
  Eigen::VectorXd displacement_in;
  double step_s = 0.001;
};

/// What the simulated rig records, converters and noise included, while it plays the paper's tones.
/// @param share  of their amplitudes
inline TwinRecord record_of(const hal::SimOptions& options, double duration_s, double share = 1.0) {
  const auto rig = hal::open_rig(options, 0.0);
  static_cast<void>(rig->set_enable(true));
  TwinRecord record;
  const auto rows = static_cast<Eigen::Index>(std::lround(duration_s / record.step_s));
  record.volts.resize(rows);
  record.displacement_in.resize(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double t = 2.0 * std::numbers::pi * record.step_s * static_cast<double>(k);
    hal::RigReading reading;
    static_cast<void>(rig->read(k * 1'000'000, reading));
    record.displacement_in[k] = reading.displacement_in;
    hal::AppliedCommand applied;
    static_cast<void>(rig->command(-0.1 + share * (1.9 * std::cos(0.05 * t + 1.8) + 1.6 * std::cos(0.2 * t + 1.9) +
                                                   1.5 * std::cos(0.65 * t + 4.2)),
                                   applied));
    record.volts[k] = applied.applied_V;
  }
  return record;
}

}  // namespace eha::replay::test
