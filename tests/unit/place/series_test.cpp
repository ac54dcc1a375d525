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
  double fastest_in_per_s = 0.0;  ///< true speed over 50 ms
};

hal::SimOptions at_mid_travel(hal::SimOptions plant) {
  plant.scale_in_per_V = 0.295;
  plant.offset_in = 2.95;
  plant.initial_displacement_in = 2.95;
  return plant;
}

config::RigConfig commissioned_rig(const hal::SimOptions& plant) {
  Random random(5);
  config::Following following = commissioned(plant, random);
  following.pressure_delay_s = 0.0;
  return rig_with(following);
}

/// A rod at mid-travel that goes on from run to run.
class Bench {
 public:
  /// @param fault  of the sensor, from the first tick of each run on
  Bench(const hal::SimOptions& drawn, std::optional<hal::InjectedFault> fault)
      : plant_(at_mid_travel(drawn)), rig_(commissioned_rig(plant_)), rod_(plant_) {
    std::vector<hal::InjectedFault> faults;
    if (fault) {
      fault->first_tick = 1;
      fault->ticks = hal::InjectedFault::kAlways;
      faults.push_back(*fault);
    }
    sensed_.emplace(
        rod_, faults, [](std::int64_t) {}, plant_.conversion());
  }

  [[nodiscard]] const config::RigConfig& rig() const { return rig_; }
  [[nodiscard]] const Series& series() const { return series_; }
  [[nodiscard]] double reading_in() const { return reading_in_; }

  /// Plays one more run, with what the runs before have left, and lets the rod come to rest. @param stopped_s  twice
  void play(acquisition::CommandSource& source, double stopped_s = 1e9) {
    acquisition::StateMachine machine;
    machine.reset();
    machine.arm();
    acquisition::VirtualClock clock;
    acquisition::TickEngine engine(*sensed_, machine, source, rig_.limits, rig_.realtime,
                                   acquisition::LatePolicy::abort, clock, earlier_);
    double before_in = rod_.place_in();
    for (std::uint32_t k = 0; !engine.finished(); ++k) {
      acquisition::TickInputs inputs;
      inputs.sequence = k;
      inputs.scheduled_ns = k * kTick_ns;
      inputs.stops = static_cast<double>(k) * kTick_s > stopped_s ? 2 : 0;
      reading_in_ = engine.tick(inputs).displacement_in;
      if (k % kTicksOfASpeed != 0) continue;
      const double way_in = k == 0 ? 0.0 : std::abs(rod_.place_in() - before_in);
      series_.fastest_in_per_s = std::max(series_.fastest_in_per_s, way_in / (kTicksOfASpeed * kTick_s));
      before_in = rod_.place_in();
    }
    rod_.rest();
    earlier_ = engine.left();
    series_.fault = engine.fault().fault;
    ++series_.runs;
    series_.moved_in = std::abs(rod_.place_in() - plant_.initial_displacement_in);
  }

 private:
  static constexpr std::uint32_t kTicksOfASpeed = 50;

  hal::SimOptions plant_;
  config::RigConfig rig_;
  LastingRod rod_;
  std::optional<hal::FaultRig> sensed_;
  acquisition::EarlierRuns earlier_;
  double reading_in_ = 2.95;
  Series series_;
};

/// Plays a step again and again, each time from where [start] finds the rod in place.
Series played(const hal::SimOptions& plant, const Step& step, int most_runs, bool sensor_is_stuck) {
  std::optional<hal::InjectedFault> fault;
  if (sensor_is_stuck) fault = hal::InjectedFault{.kind = hal::FaultKind::stuck_sensor, .noise_LSB = 3.0};
  Bench bench(plant, fault);
  const config::RigLimits& limits = bench.rig().limits;
  std::vector<double> table(static_cast<std::size_t>(std::lround((step.lasts_s + 0.1) / kTick_s)), 0.0);
  for (std::size_t i = 50; i + 50 < table.size(); ++i) table[i] = limits.following->null_V + step.volts;
  const Series& series = bench.series();
  while (series.runs < most_runs && (series.fault == Fault::none || series.fault == Fault::second_stop)) {
    place::StartingSource source(place::PlaceController(limits, kTick_s, 2.95), limits, kTick_s,
                                 std::make_unique<acquisition::TableSource>(table, 1));
    bench.play(source, step.stopped_s);
  }
  return series;
}

/// Jogs a rod by the reading until one of them ends by a fault. @param slope  of the sensor, of its own
Series jogged(const hal::SimOptions& plant, double jog_in, int most_runs, double slope) {
  std::optional<hal::InjectedFault> fault;
  if (slope < 1.0) fault = hal::InjectedFault{.kind = hal::FaultKind::scaled_sensor, .amount = slope};
  Bench bench(plant, fault);
  while (bench.series().runs < most_runs && bench.series().fault == Fault::none) {
    place::PlaceSource source(place::PlaceController(bench.rig().limits, kTick_s, bench.reading_in() + jog_in), 40'000);
    bench.play(source);
  }
  return bench.series();
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
