// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "config/characterisation.hpp"
#include "config/rig_config.hpp"
#include "daemon/acquisition/tick_engine.hpp"
#include "daemon/place/exploring_source.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "tests/unit/acquisition/true_rod.hpp"
#include "tests/unit/passing_rig.hpp"

// Characterisations of rigs of which nothing is known, with a sensor that is not right: real tick engine, limits,
// sources and simulated cylinder.

namespace eha::place {

inline constexpr std::int64_t kPeriod_ns = 1'000'000;
inline constexpr double kStrokeOfRig_in = 150.0 / 25.4;
inline constexpr double kContact_in = 0.01;  ///< a rod so near to the stop has met it

/// From the environment, or the usual value.
inline int number_of(const char* variable, int usual) {
  const char* asked = std::getenv(variable);
  return asked != nullptr ? std::atoi(asked) : usual;
}

/// Shows a rod about a place, as a scale does that is wrong by a factor.
class MisscaledRig final : public test::PassingRig {
 public:
  MisscaledRig(hal::Rig& rig, double factor, double about_in) : PassingRig(rig), factor_(factor), about_in_(about_in) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const hal::RigStatus status = PassingRig::read(elapsed_ns, reading);
    reading.displacement_in = about_in_ + factor_ * (reading.displacement_in - about_in_);
    return status;
  }

 private:
  double factor_;
  double about_in_;
};

/// What is added to the sensor's reading [in] at a time [s].
using Disturbance = std::function<double(double time_s)>;

class DisturbedRig final : public test::PassingRig {
 public:
  DisturbedRig(hal::Rig& rig, Disturbance disturbance) : PassingRig(rig), disturbance_(std::move(disturbance)) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const hal::RigStatus status = PassingRig::read(elapsed_ns, reading);
    if (disturbance_) reading.displacement_in += disturbance_(1e-9 * static_cast<double>(elapsed_ns));
    return status;
  }

 private:
  Disturbance disturbance_;
};

/// Whose pressure comes late.
class LatePressureRig final : public test::PassingRig {
 public:
  LatePressureRig(hal::Rig& rig, double late_s) : PassingRig(rig), late_s_(late_s) {}
  hal::RigStatus read(std::int64_t elapsed_ns, hal::RigReading& reading) noexcept override {
    const bool comes = is_enabled_ && !has_pressure_ && elapsed_ns >= static_cast<std::int64_t>(1e9 * late_s_);
    if (comes) (void)set_pressure(true);
    return PassingRig::read(elapsed_ns, reading);
  }
  hal::RigStatus set_enable(bool on) noexcept override {
    is_enabled_ = on;
    return set_pressure(on && late_s_ <= 0.0);
  }

 private:
  hal::RigStatus set_pressure(bool on) noexcept {
    has_pressure_ = on;
    return PassingRig::set_enable(on);
  }

  double late_s_;
  bool is_enabled_ = false;
  bool has_pressure_ = false;
};

/// A simulated rig of which nothing is known.
struct Drawn {
  hal::SimOptions plant;
  double gain_in_per_V_s = 0.0;
  double factor = 1.0;    ///< of the scale
  double about_in = 0.0;  ///< where the sensor is right
  Disturbance disturbance;
  double pressure_delay_s = 0.0;
};

/// A rod of 0.1 to 2 in/(V s) whose sensor's scale is wrong by 0.4 to 2.5.
inline Drawn drawn(unsigned run) {
  std::mt19937_64 random(70'000 + run);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Drawn rig;
  rig.gain_in_per_V_s = 0.1 * std::exp(uniform(0.0, std::log(20.0)));
  hal::SimOptions& plant = rig.plant;
  plant.valve_rated_flow_L_per_min *= rig.gain_in_per_V_s / 0.14;
  plant.valve_dead_band_V = uniform(0.05, 0.6);
  plant.valve_null_offset_V = uniform(-0.3, 0.3);
  const double friction = std::exp(uniform(0.0, std::log(3.0)));
  plant.coulomb_friction_N *= friction;
  plant.static_friction_N *= friction;
  plant.viscous_friction_N_s_per_mm *= friction;
  plant.moving_mass_kg *= uniform(1.0, 3.0);
  // Neither the converter's ends nor the sensor's band are near the stops: they protect not every rig.
  plant.scale_in_per_V = 0.35;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = uniform(0.3, 5.6);
  plant.sensor_noise_V = uniform(0.0003, 0.005);
  plant.seed = random();
  // As long as the stiffness, friction and mass allow.
  while (!hal::check(plant).empty() && plant.sub_step_us > 10.0) plant.sub_step_us -= 2.0;
  rig.factor = std::exp(uniform(std::log(0.4), std::log(2.5)));
  rig.about_in = 0.5 * kStrokeOfRig_in * std::floor(uniform(0.0, 3.0));
  return rig;
}

struct Measured {
  acquisition::Fault fault = acquisition::Fault::none;
  double at_s = 0.0;
  double impact_in_per_s = 0.0;   ///< true speed over the 0.1 s before the rod met a stop; the greatest
  double fastest_in_per_s = 0.0;  ///< true speed over 50 ms, from the failure of the sensor on
  double way_in = 0.0;            ///< farthest true place from where the rod was when the sensor failed
  bool is_complete = false;
};

/// A rig file of a machine without [following], whose sensor's band protects from nothing.
inline config::RigConfig unknown_rig() {
  config::RigConfig rig = config::load_rig(EHA_SOURCE_DIR "/config/rigs/pci1716.toml");
  rig.limits.following.reset();
  rig.limits.sensor.reset();
  return rig;
}

/// Characterises a rod through the real tick engine. @param fault  of the sensor; none: it is sound but for its scale
inline Measured measured(const Drawn& drawn, const config::RigConfig& rig,
                         const std::optional<hal::InjectedFault>& fault = {}) {
  const config::RigLimits& limits = rig.limits;
  const double step_s = rig.realtime.sample_period_s;
  const ident::SheetPlan plan = config::characterisation_plan(rig);
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(drawn.plant, limits.safe_V);
  LatePressureRig pressed(*sim, drawn.pressure_delay_s);
  acquisition::TrueRod rod(pressed);
  std::vector<hal::InjectedFault> faults;
  if (fault) faults.push_back(*fault);
  hal::FaultRig sensed(
      rod, faults, [](std::int64_t) {}, drawn.plant.conversion());
  MisscaledRig scaled(sensed, drawn.factor, drawn.about_in);
  DisturbedRig shown(scaled, drawn.disturbance);
  acquisition::StateMachine machine;
  machine.reset();
  machine.arm();
  acquisition::VirtualClock clock;
  ExploringSource source({plan.table_V.data(), static_cast<std::size_t>(plan.table_V.size())}, plan,
                         config::centring_of(limits), limits, step_s);
  acquisition::TickEngine engine(shown, machine, source, limits, {}, acquisition::LatePolicy::abort, clock);
  Measured result;
  std::vector<double> sums{0.0};
  double failed_in = drawn.plant.initial_displacement_in;
  bool is_at_stop = false;
  std::int64_t rest = 300;
  for (std::int64_t k = 0; rest > 0; ++k) {
    if (engine.finished()) {
      --rest;
      hal::RigReading ignored;
      (void)rod.read(k * kPeriod_ns, ignored);
    } else {
      acquisition::TickInputs inputs;
      inputs.sequence = static_cast<std::uint32_t>(k);
      inputs.scheduled_ns = k * kPeriod_ns;
      (void)engine.tick(inputs);
    }
    sums.push_back(sums.back() + rod.place_in);
    if (k < 100) continue;
    // Means of 40 readings, 60 ms apart: the plant's readings are noisy.
    const auto mean_in = [&](std::int64_t from) {
      return (sums[static_cast<std::size_t>(from + 40)] - sums[static_cast<std::size_t>(from)]) / 40.0;
    };
    const double now_in = mean_in(k - 39);
    const bool meets = now_in < kContact_in || now_in > kStrokeOfRig_in - kContact_in;
    if (meets && !is_at_stop) {
      result.impact_in_per_s = std::max(result.impact_in_per_s, std::abs(now_in - mean_in(k - 99)) / 0.06);
    }
    is_at_stop = meets;
    if (fault && k <= fault->first_tick) failed_in = now_in;
    if (!fault || k <= fault->first_tick) continue;
    result.way_in = std::max(result.way_in, std::abs(now_in - failed_in));
    const auto short_mean_in = [&](std::int64_t from) {
      return (sums[static_cast<std::size_t>(from + 10)] - sums[static_cast<std::size_t>(from)]) / 10.0;
    };
    result.fastest_in_per_s =
        std::max(result.fastest_in_per_s, std::abs(short_mean_in(k - 9) - short_mean_in(k - 59)) / 0.05);
  }
  result.fault = engine.fault().fault;
  result.at_s = static_cast<double>(engine.fault().at_ns) * 1e-9;
  result.is_complete = result.fault == acquisition::Fault::none;
  return result;
}

}  // namespace eha::place
