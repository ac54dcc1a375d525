// SPDX-License-Identifier: GPL-3.0-or-later
// Series of short runs on one rod, each with monitors of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "daemon/place/place_source.hpp"
#include "tests/unit/place/driven_rod.hpp"

namespace eha::test {
namespace {

/// A rod that stays where a run leaves it, in a time that goes on.
class LastingRod final : public hal::Rig {
 public:
  explicit LastingRod(const hal::SimOptions& plant) : sim_(hal::open_rig(plant, 0.0)), rod_(*sim_) {}
  [[nodiscard]] const hal::RigCapabilities& capabilities() const noexcept override { return rod_.capabilities(); }
  hal::RigStatus read(std::int64_t at_ns, hal::RigReading& reading) noexcept override {
    last_ns_ = begun_ns_ + at_ns;
    return rod_.read(last_ns_, reading);
  }
  hal::RigStatus command(double command_V, hal::AppliedCommand& applied) noexcept override {
    return rod_.command(command_V, applied);
  }
  hal::RigStatus set_enable(bool on) noexcept override { return rod_.set_enable(on); }
  hal::RigStatus make_safe() noexcept override { return rod_.make_safe(); }
  [[nodiscard]] std::string safe_snapshot() const override { return rod_.safe_snapshot(); }

  /// The rod comes to rest; the next run's time begins at 0.
  void rest() {
    hal::RigReading ignored;
    for (int k = 1; k <= 500; ++k) (void)rod_.read(last_ns_ + k * kTick_ns, ignored);
    begun_ns_ = last_ns_ + 501 * kTick_ns;
  }
  [[nodiscard]] double place_in() const noexcept { return rod_.place_in; }

 private:
  std::unique_ptr<hal::Rig> sim_;
  acquisition::TrueRod rod_;
  std::int64_t begun_ns_ = 0;
  std::int64_t last_ns_ = 0;
};

struct Step {
  double volts = 0.0;  ///< from the null
  double lasts_s = 0.0;
  double stopped_s = 1e9;  ///< two stops come then, in each run
};

struct Series {
  int runs = 0;  ///< with the one that a fault ended
  Fault fault = Fault::none;
  double moved_in = 0.0;          ///< true way from where the series began
  double fastest_in_per_s = 0.0;  ///< true speed over 50 ms; of jogs only
};

/// Plays a step again and again, each time from where [start] finds the rod in place.
Series played(hal::SimOptions plant, const Step& step, int most_runs, bool sensor_is_stuck) {
  plant.scale_in_per_V = 0.295;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = 2.95;
  Random random(5);
  config::Following following = commissioned(plant, random);
  following.pressure_delay_s = 0.0;
  const config::RigConfig rig = rig_with(following);
  LastingRod rod(plant);
  std::vector<hal::InjectedFault> faults;
  if (sensor_is_stuck) {
    faults.push_back({.kind = hal::FaultKind::stuck_sensor,
                      .first_tick = 1,
                      .ticks = hal::InjectedFault::kAlways,
                      .noise_LSB = 3.0});
  }
  hal::FaultRig sensed(
      rod, faults, [](std::int64_t) {}, plant.conversion());
  std::vector<double> table(static_cast<std::size_t>(std::lround((step.lasts_s + 0.1) / kTick_s)), 0.0);
  for (std::size_t i = 50; i + 50 < table.size(); ++i) table[i] = following.null_V + step.volts;
  acquisition::EarlierRuns earlier;
  Series series;
  while (series.runs < most_runs && (series.fault == Fault::none || series.fault == Fault::second_stop)) {
    place::StartingSource source(place::PlaceController(rig.limits, kTick_s, 2.95), rig.limits, kTick_s,
                                 std::make_unique<acquisition::TableSource>(table, 1));
    acquisition::StateMachine machine;
    machine.reset();
    machine.arm();
    acquisition::VirtualClock clock;
    acquisition::TickEngine engine(sensed, machine, source, rig.limits, rig.realtime, acquisition::LatePolicy::abort,
                                   clock, earlier);
    for (std::uint32_t k = 0; !engine.finished(); ++k) {
      acquisition::TickInputs inputs;
      inputs.sequence = k;
      inputs.scheduled_ns = k * kTick_ns;
      inputs.stops = static_cast<double>(k) * kTick_s > step.stopped_s ? 2 : 0;
      (void)engine.tick(inputs);
    }
    rod.rest();
    earlier = engine.left();
    series.fault = engine.fault().fault;
    ++series.runs;
  }
  series.moved_in = std::abs(rod.place_in() - 2.95);
  return series;
}

/// Jogs a rod by the reading until one of them ends by a fault. @param slope  of the sensor, of its own
Series jogged(hal::SimOptions plant, double jog_in, int most_runs, double slope) {
  plant.scale_in_per_V = 0.295;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = 2.95;
  Random random(5);
  config::Following following = commissioned(plant, random);
  following.pressure_delay_s = 0.0;
  const config::RigConfig rig = rig_with(following);
  LastingRod rod(plant);
  std::vector<hal::InjectedFault> faults;
  if (slope < 1.0) {
    faults.push_back({.kind = hal::FaultKind::scaled_sensor,
                      .first_tick = 1,
                      .ticks = hal::InjectedFault::kAlways,
                      .amount = slope});
  }
  hal::FaultRig sensed(
      rod, faults, [](std::int64_t) {}, plant.conversion());
  acquisition::EarlierRuns earlier;
  Series series;
  double reading_in = 2.95;
  for (; series.runs < most_runs && series.fault == Fault::none; ++series.runs) {
    place::PlaceSource source(place::PlaceController(rig.limits, kTick_s, reading_in + jog_in), 40'000);
    acquisition::StateMachine machine;
    machine.reset();
    machine.arm();
    acquisition::VirtualClock clock;
    acquisition::TickEngine engine(sensed, machine, source, rig.limits, rig.realtime, acquisition::LatePolicy::abort,
                                   clock, earlier);
    double before_in = rod.place_in();
    for (std::uint32_t k = 0; !engine.finished(); ++k) {
      acquisition::TickInputs inputs;
      inputs.sequence = k;
      inputs.scheduled_ns = k * kTick_ns;
      reading_in = engine.tick(inputs).displacement_in;
      if (k % 50 == 0) {
        if (k > 0)
          series.fastest_in_per_s = std::max(series.fastest_in_per_s, std::abs(rod.place_in() - before_in) / 0.05);
        before_in = rod.place_in();
      }
    }
    rod.rest();
    earlier = engine.left();
    series.fault = engine.fault().fault;
  }
  series.moved_in = std::abs(rod.place_in() - 2.95);
  return series;
}

hal::SimOptions rod_of(double flow) {
  hal::SimOptions plant;
  plant.valve_rated_flow_L_per_min *= flow;
  plant.valve_dead_band_V = 0.15;
  return plant;
}

TEST(SeriesOfRuns, EndsOnASensorThatIsDead) {
  for (const Step& step : {Step{4.0, 0.1}, Step{4.0, 0.08}, Step{-3.0, 0.1}, Step{1.0, 0.2}}) {
    const Series fast = played(rod_of(8.5), step, 30, true);
    EXPECT_EQ(fast.fault, Fault::not_following) << step.volts;
    EXPECT_LT(fast.moved_in, 0.5) << step.volts << " V, " << fast.runs << " runs";
  }
  const Series slow = played(rod_of(1.0), {4.0, 0.1}, 30, true);
  EXPECT_EQ(slow.fault, Fault::not_following);
  EXPECT_LT(slow.moved_in, 0.4) << slow.runs;
}

TEST(SeriesOfRuns, EndsOnASensorThatIsDeadWhateverEndedTheRunsBefore) {
  // From before the step to after it.
  bool is_found = false;
  for (double stopped_s = 0.5; stopped_s < 2.5; stopped_s += 0.04) {
    const Series stopped = played(rod_of(8.5), {4.0, 0.1, stopped_s}, 30, true);
    // A step that is stopped within its first hundredths of a second misses too little to count.
    EXPECT_LT(stopped.moved_in, 0.9) << stopped.runs << " runs, stopped at " << stopped_s << " s";
    is_found = is_found || (stopped.fault == Fault::not_following && stopped.runs > 2);
  }
  EXPECT_TRUE(is_found);
}

TEST(SeriesOfRuns, GoesOnWithASoundSensor) {
  for (const double flow : {1.0, 8.5}) {
    for (const Step& step : {Step{4.0, 0.1}, Step{4.0, 0.04}, Step{-3.0, 0.1}, Step{1.0, 0.2}, Step{0.4, 0.5}}) {
      const Series series = played(rod_of(flow), step, 30, false);
      EXPECT_EQ(series.fault, Fault::none) << flow << ": " << step.volts << " V, run " << series.runs;
    }
  }
}

TEST(SeriesOfRuns, EndsOnASensorThatShowsHalfOfEachJogOrKeepsSlow) {
  for (const double flow : {1.0, 2.0, 4.0, 6.0, 8.5}) {
    for (const double jog_in : {0.15, 0.2, -0.2}) {
      const Series series = jogged(rod_of(flow), jog_in, 60, 0.5);
      EXPECT_EQ(series.fault, Fault::wrong_speed) << flow << ": " << jog_in << " in, " << series.runs << " runs";
      EXPECT_LT(series.moved_in, 0.5) << flow << ": " << jog_in << " in, " << series.runs << " runs";
    }
    // The volts of a shorter one lie within the valve's errors.
    const Series slow = jogged(rod_of(flow), 0.05, 60, 0.5);
    EXPECT_LT(slow.fastest_in_per_s, 0.15) << flow << ": " << slow.runs << " runs";
  }
}

TEST(SeriesOfRuns, JogsOnWithASoundSensor) {
  for (const double flow : {1.0, 4.0, 8.5}) {
    for (const double jog_in : {0.05, 0.1, 0.2, -0.1}) {
      const Series series = jogged(rod_of(flow), jog_in, 12, 1.0);
      EXPECT_EQ(series.fault, Fault::none) << flow << ": " << jog_in << " in, run " << series.runs;
    }
  }
}

}  // namespace
}  // namespace eha::test
