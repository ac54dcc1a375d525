// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "daemon/replay/twin_calibration.hpp"
#include "daemon/replay/twin_parameter.hpp"
#include "tests/unit/replay/twin_record.hpp"

namespace eha::replay {
namespace {

// Of a right 95 % interval forty cover 38 on average; 34, as 17 of twenty, is over three standard deviations lower.
constexpr int kSeeds = 40;
constexpr int kFewestInside = 34;
constexpr std::array kKeys{"valve_null_offset_V", "valve_dead_band_V", "supply_pressure_bar", "moving_mass_kg"};

TEST(CalibrationCoverage, HoldsForFourParametersChangedByUpToFortyPercent) {
  std::array<int, kKeys.size()> inside{};
  for (int seed = 100; seed < 100 + kSeeds; ++seed) {
    std::mt19937_64 generator(static_cast<std::uint64_t>(seed));
    hal::SimOptions truth;
    truth.seed = static_cast<std::uint64_t>(1000 + 7 * seed);
    truth.sub_step_us = 25.0;
    for (const char* key : kKeys) {
      const double share = 0.8 * (static_cast<double>(generator() >> 11) * 0x1p-53) - 0.4;
      truth = with_value(truth, key, value_of(truth, key) * (1.0 + share));
    }
    const test::TwinRecord record = test::record_of(truth, 10.0);
    std::vector<CalibrationRequest> requests;
    for (const char* key : kKeys) requests.push_back({key, {}});
    const Calibration found = calibrate({}, requests, record.volts, record.displacement_in, record.step_s);
    for (std::size_t i = 0; i < kKeys.size(); ++i) {
      const CalibratedParameter& p = found.parameters[i];
      const double wanted = value_of(truth, kKeys[i]);
      const double error = std::abs(p.value - wanted);
      inside[i] += error <= p.half_width ? 1 : 0;
      if (i < 2) {
        EXPECT_LT(error, 0.05 * wanted) << kKeys[i] << ", seed " << seed;
      }
    }
  }
  for (std::size_t i = 0; i < kKeys.size(); ++i) {
    EXPECT_GE(inside[i], kFewestInside) << kKeys[i];
    RecordProperty(kKeys[i], inside[i]);
  }
}

}  // namespace
}  // namespace eha::replay
