// SPDX-License-Identifier: GPL-3.0-or-later
// The following check against many simulated rigs: sound ones must play every excitation to its end, and one whose
// sensor fails must be stopped before the rod meets an end stop. The real tick engine, limits and simulated cylinder.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "daemon/acquisition/tick_engine.hpp"
#include "hal/faults/fault_rig.hpp"
#include "hal/sim/sim_rig.hpp"
#include "ident/excitation/excitation.hpp"
#include "tests/unit/acquisition/true_rod.hpp"

namespace eha::acquisition {
namespace {

constexpr double kTick_s = 0.001;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr double kStroke_in = 150.0 / 25.4;
constexpr double kRun_s = 12.0;

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Runs of each kind; EHA_CAMPAIGN_RUNS overrides.
int runs_wanted(int usual) {
  const char* asked = std::getenv("EHA_CAMPAIGN_RUNS");
  return asked != nullptr ? std::atoi(asked) : usual;
}

/// A rig of the size of sim.toml's with another valve, friction and load. Its sensor reads mid-stroke at 0 V.
hal::SimOptions random_plant(Random& random) {
  hal::SimOptions plant;
  plant.valve_dead_band_V = uniform(random, 0.05, 0.6);
  plant.valve_null_offset_V = uniform(random, -0.3, 0.3);
  const double friction = std::exp(uniform(random, 0.0, std::log(5.0)));
  plant.coulomb_friction_N *= friction;
  plant.static_friction_N *= friction;
  plant.viscous_friction_N_s_per_mm *= friction;
  // Keeps the slope at rest, and so the integration step, that of the shipped rig.
  plant.friction_regularisation_mm_per_s *= friction;
  plant.moving_mass_kg *= uniform(random, 1.0, 3.0);
  plant.scale_in_per_V = 0.295;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = 2.95;
  plant.sensor_noise_V = uniform(random, 0.0003, 0.005);
  plant.seed = random();
  return plant;
}

config::RigLimits limits_of_the_rig() {
  return {.command_min_V = -5.0,
          .command_max_V = 5.0,
          .slew_V_per_s = 20.0,
          .safe_V = 0.0,
          .travel_min_in = 0.15,
          .travel_max_in = 5.75,
          .stopping_deceleration_in_per_s2 = 200.0,
          .velocity_limit_in_per_s = 8.0,
          .frozen_sensor_s = 0.5,
          .following = std::nullopt,
          .sensor = std::nullopt};
}

/// Mean speed at a held command, once it is steady [in/s].
double steady_speed(const hal::SimOptions& plant, double command_V) {
  hal::SimOptions quiet = plant;
  quiet.sensor_noise_V = 0.0;
  const std::unique_ptr<hal::Rig> rig = hal::open_rig(quiet, 0.0);
  hal::AppliedCommand applied;
  hal::RigReading before;
  hal::RigReading after;
  EXPECT_EQ(rig->command(command_V, applied), hal::RigStatus::ok);
  EXPECT_EQ(rig->set_enable(true), hal::RigStatus::ok);
  EXPECT_EQ(rig->read(300'000'000, before), hal::RigStatus::ok);
  EXPECT_EQ(rig->read(500'000'000, after), hal::RigStatus::ok);
  return (after.displacement_in - before.displacement_in) / 0.2;
}

/// What commissioning finds: the gains from a step each way, the null to 0.03 V, the dead band and 0.05 V.
config::Following commissioned(const hal::SimOptions& plant, Random& random) {
  const double null_V = -plant.valve_null_offset_V;
  const double outside_V = 1.5;
  const double step_V = plant.valve_dead_band_V + outside_V;
  return {.gain_positive_in_per_V_s = 0.5 * steady_speed(plant, null_V + step_V) / outside_V,
          .gain_negative_in_per_V_s = -0.5 * steady_speed(plant, null_V - step_V) / outside_V,
          .null_V = null_V + uniform(random, -0.03, 0.03),
          .dead_band_V = plant.valve_dead_band_V + 0.05,
          .limit_in = 0.1,
          .pressure_delay_s = 0.0};
}

/// Volts of a randomly chosen kind of excitation.
Eigen::VectorXd random_table(Random& random, std::string& name) {
  const double amplitude_V = uniform(random, 0.5, 4.5);
  const std::uint64_t seed = random() >> 1U;
  ident::Excitation excitation;
  switch (std::uniform_int_distribution<int>(0, 6)(random)) {
    case 0: {
      ident::Multisine kind;
      for (const double frequency_Hz : {0.1, 0.35, uniform(random, 0.5, 2.0)}) {
        kind.tones.push_back(
            {.frequency_Hz = frequency_Hz, .amplitude_V = amplitude_V / 3.0, .phase_rad = uniform(random, 0.0, 6.28)});
      }
      excitation.kind = kind;
      break;
    }
    case 1: {
      ident::OddRandomMultisine kind;
      kind.amplitude_V = amplitude_V;
      kind.band = {0.25, uniform(random, 2.0, 8.0)};
      kind.seed = seed;
      excitation.kind = kind;
      break;
    }
    case 2: {
      ident::Prms kind;
      kind.amplitude_V = amplitude_V;
      kind.levels = 5;
      kind.hold_s = uniform(random, 0.1, 0.5);
      kind.seed = seed;
      excitation.kind = kind;
      break;
    }
    case 3: {
      ident::Chirp kind;
      kind.amplitude_V = amplitude_V;
      kind.band = {0.2, uniform(random, 2.0, 10.0)};
      excitation.kind = kind;
      break;
    }
    case 4: {
      ident::Gaussian kind;
      kind.amplitude_V = amplitude_V;
      kind.band = {0.1, uniform(random, 1.0, 10.0)};
      kind.seed = seed;
      excitation.kind = kind;
      break;
    }
    case 5: {
      ident::Step kind;
      kind.amplitude_V = amplitude_V;
      kind.hold_s = uniform(random, 0.2, 2.0);
      excitation.kind = kind;
      break;
    }
    default: {
      ident::Sine kind;
      kind.tones = {{.frequency_Hz = uniform(random, 0.15, 3.0), .amplitude_V = amplitude_V, .phase_rad = 0.0}};
      excitation.kind = kind;
      break;
    }
  }
  name = ident::name_of(excitation.kind);
  const Eigen::VectorXd volts =
      ident::excitation(excitation, kTick_s, static_cast<std::size_t>(std::llround(kRun_s / kTick_s)));
  return volts.cwiseMax(-5.0).cwiseMin(5.0);
}

struct Played {
  FaultReport fault;
  double farthest_in = 0.0;   ///< true travel after the sensor failed, until the rig was safe [in]
  bool met_end_stop = false;  ///< the rod truly came within 0.02 in of one
};

/// Plays volts on a plant whose sensor fails at a tick; none: it does not.
Played play_on(const hal::SimOptions& plant, const config::RigLimits& limits, const Eigen::VectorXd& table_V,
               const std::optional<hal::InjectedFault>& fault) {
  const std::unique_ptr<hal::Rig> sim = hal::open_rig(plant, limits.safe_V);
  TrueRod rod(*sim);
  std::vector<hal::InjectedFault> faults;
  if (fault) faults.push_back(*fault);
  hal::FaultRig rig(
      rod, faults, [](std::int64_t) {}, plant.conversion());
  StateMachine machine;
  machine.reset();
  machine.arm();
  VirtualClock clock;
  TableSource source({table_V.data(), static_cast<std::size_t>(table_V.size())}, 1);
  TickEngine engine(rig, machine, source, limits, {}, LatePolicy::abort, clock);
  Played played;
  double start_in = plant.initial_displacement_in;
  for (std::int64_t k = 0; !engine.finished(); ++k) {
    TickInputs inputs;
    inputs.sequence = static_cast<std::uint32_t>(k);
    inputs.scheduled_ns = k * kTick_ns;
    (void)engine.tick(inputs);
    if (!fault) continue;
    if (k <= fault->first_tick) start_in = rod.place_in;
    if (k >= fault->first_tick) played.farthest_in = std::max(played.farthest_in, std::abs(rod.place_in - start_in));
    played.met_end_stop = played.met_end_stop || rod.place_in < 0.02 || rod.place_in > kStroke_in - 0.02;
  }
  played.fault = engine.fault();
  return played;
}

bool is_of_following(Fault fault) { return fault == Fault::not_following || fault == Fault::unexplained_motion; }

/// Counts the runs of sound rigs that the following check ends.
int false_trips(bool with_following, int runs) {
  int trips = 0;
  int limited = 0;
  for (int run = 0; run < runs; ++run) {
    Random random(1000 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    config::RigLimits limits = limits_of_the_rig();
    const config::Following following = commissioned(plant, random);
    if (with_following) limits.following = following;
    std::string name;
    const Eigen::VectorXd table_V = random_table(random, name);
    const Played played = play_on(plant, limits, table_V, std::nullopt);
    if (played.fault.fault != Fault::none) ++limited;
    if (!is_of_following(played.fault.fault)) continue;
    ++trips;
    ADD_FAILURE() << "run " << run << ", " << name << ": " << to_text(played.fault.fault) << " at "
                  << static_cast<double>(played.fault.at_ns) * 1e-9 << " s, " << played.fault.value << " in, dead band "
                  << plant.valve_dead_band_V << " V, null " << -plant.valve_null_offset_V << " V";
  }
  std::printf("%d runs of sound rigs, %d ended by a limit of the rig, %d false trips\n", runs, limited, trips);
  return trips;
}

hal::InjectedFault random_sensor_fault(Random& random) {
  hal::InjectedFault fault{.kind = hal::FaultKind::stuck_sensor,
                           .first_tick = 0,
                           .ticks = hal::InjectedFault::kAlways,
                           .amount = 0.0,
                           .noise_LSB = uniform(random, 0.0, 30.0)};
  const int kind = std::uniform_int_distribution<int>(0, 3)(random);
  if (kind == 0) fault.kind = hal::FaultKind::open_sensor;  // 0 V, which is mid-stroke
  if (kind == 1) fault.kind = hal::FaultKind::reversed_sensor;
  if (kind == 2) fault.noise_LSB = 0.0;
  // From the start, or in mid-run.
  if (uniform(random, 0.0, 1.0) < 0.5) fault.first_tick = static_cast<std::int64_t>(uniform(random, 300.0, 6000.0));
  return fault;
}

TEST(FollowingCampaign, NeverStopsASoundRigThatIsCommissioned) { EXPECT_EQ(false_trips(true, runs_wanted(1000)), 0); }

TEST(FollowingCampaign, NeverStopsASoundRigWithoutItsNumbers) { EXPECT_EQ(false_trips(false, runs_wanted(1000)), 0); }

TEST(FollowingCampaign, StopsACommissionedRigWhoseSensorFailsBeforeAnEndStop) {
  constexpr double kGreatestTravel_in = 0.7;
  double worst_in = 0.0;
  int untripped = 0;
  const int runs = runs_wanted(500);
  for (int run = 0; run < runs; ++run) {
    Random random(50'000 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    config::RigLimits limits = limits_of_the_rig();
    limits.following = commissioned(plant, random);
    std::string name;
    const Eigen::VectorXd table_V = random_table(random, name);
    const hal::InjectedFault fault = random_sensor_fault(random);
    const Played played = play_on(plant, limits, table_V, fault);
    EXPECT_FALSE(played.met_end_stop) << "run " << run << ", " << name;
    if (played.fault.fault == Fault::none) ++untripped;
    worst_in = std::max(worst_in, played.farthest_in);
    EXPECT_LE(played.farthest_in, kGreatestTravel_in)
        << "run " << run << ", " << name << ", fault " << static_cast<int>(fault.kind) << " from tick "
        << fault.first_tick << ", ended by " << to_text(played.fault.fault);
  }
  std::printf("%d runs with a failing sensor: worst true travel %.3f in, %d ran to their end\n", runs, worst_in,
              untripped);
}

TEST(FollowingCampaign, StopsAStepFromMidStrokeWithoutTheRigsNumbers) {
  ident::Step step;
  step.amplitude_V = 2.0;
  step.hold_s = 0.2;
  ident::Excitation excitation;
  excitation.kind = step;
  const Eigen::VectorXd up_V = ident::excitation(excitation, kTick_s, 6000);
  const int runs = runs_wanted(200);
  double worst_in = 0.0;
  for (int run = 0; run < runs; ++run) {
    Random random(90'000 + static_cast<unsigned>(run));
    const hal::SimOptions plant = random_plant(random);
    hal::InjectedFault fault = random_sensor_fault(random);
    fault.first_tick = 0;
    const Eigen::VectorXd table_V = run % 2 == 0 ? up_V : Eigen::VectorXd(-up_V);
    const Played played = play_on(plant, limits_of_the_rig(), table_V, fault);
    EXPECT_FALSE(played.met_end_stop) << "run " << run;
    worst_in = std::max(worst_in, played.farthest_in);
  }
  std::printf("%d steps of 2 V with a failing sensor and no [following]: worst true travel %.3f in\n", runs, worst_in);
}

}  // namespace
}  // namespace eha::acquisition
