// SPDX-License-Identifier: GPL-3.0-or-later
// Controllers' trials on simulated rigs that move a machine as far as limits and checks go: aborted at random moments,
// with a sensor that fails, and with one wrong number in the controller's file. The real tick engine and limits.
// EHA_CAMPAIGN_RUNS: how many instead of 1000. EHA_CAMPAIGN_FIRST: other draws.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "core/error.hpp"
#include "daemon/rig/arming.hpp"
#include "daemon/track/track_source.hpp"
#include "daemon/tune/tune_inputs.hpp"
#include "tests/unit/place/driven_rod.hpp"

namespace eha::track {
namespace {

using acquisition::Fault;
using namespace test;

constexpr int kRunsOfAPlant = 25;

/// A plant as it was commissioned, and a controller for it.
struct Axis {
  hal::SimOptions plant;
  config::RigConfig rig;
  std::string controller;
};

std::optional<Axis> axis(unsigned seed) {
  Random random(seed);
  Axis axis{.plant = random_plant(random), .rig = {}, .controller = {}};
  axis.rig = rig_with(commissioned(axis.plant, random));
  const config::ValveEstimate valve = config::valve_estimate(*axis.rig.limits.following);
  ident::Model model;
  model.name = "rod";
  model.input_unit = "V";
  model.output_unit = "in";
  model.input_map =
      ident::ValveMap{valve.null_V, valve.dead_band_V, valve.gain_negative_in_per_V_s / valve.gain_positive_in_per_V_s};
  model.transfer_function = {{{valve.gain_positive_in_per_V_s, 0}}, {{0.0065, 2}, {1, 1}}, 0.0};
  model.initial_output = 2.95;
  tune::TuneInputs inputs = tune::tune_inputs(model, axis.rig, {.kind = ident::FeedbackKind::p});
  inputs.task.axis.noise = axis.plant.sensor_noise_V * axis.plant.scale_in_per_V;
  inputs.task.twin = axis.plant;
  inputs.task.twins = 4;
  inputs.task.hold_s = 4.0;
  inputs.task.axis.draws = 40;
  config::ControllerProvenance from{.model = "model.json",
                                    .model_sha256 = std::string(64, '0'),
                                    .rig = axis.rig.name,
                                    .rig_file = "rig.toml",
                                    .rig_sha256 = std::string(64, '0'),
                                    .twin = "itself",
                                    .run = "unknown",
                                    .made_by = "test"};
  try {
    const tune::Tuned tuned = tune::tune(inputs.plant, inputs.task);
    axis.controller = config::controller_text(tune::controller_of(tuned, inputs, std::move(from), "axis"));
  } catch (const DataError&) {  // nothing suits such a rod
    return std::nullopt;
  }
  return axis;
}

/// The trial of a controller's text on a rig. @throws ConfigError  it is refused
config::Track trial(const Axis& axis, const std::string& controller) {
  const config::PreparedExperiment prepared = config::parse_prepared_experiment(
      "schema = 1\nname = \"track\"\n\n[track]\nhold_s = 3.0\ntrapezoids = 1\nsweep = true\ncontroller = '''\n" +
          controller + "'''\n",
      "track.toml", axis.rig);
  return prepared.config.tracking()->track;
}

double reference_velocity(const config::Track& track) { return track.controller.settings.reference.velocity; }

/// Each run's axis; one tuning serves many runs.
class Axes {
 public:
  const Axis& of(int run) {
    const int plant = run / kRunsOfAPlant;
    if (plant != plant_) {
      plant_ = plant;
      do {
        axis_ = axis(next_++);
      } while (!axis_ || !arming_findings(axis_->rig).refusals.empty());
    }
    return *axis_;
  }

 private:
  int plant_ = -1;
  unsigned next_ = 7000 + first_wanted();
  std::optional<Axis> axis_;
};

struct Count {
  int runs = 0;
  int refused = 0;
  double fastest = 0.0;  ///< over the tuned reference's velocity
  double lost_in = 0.0;
  std::map<std::string, int> faults;
};

void print(const std::map<std::string, Count>& counts) {
  for (const auto& [name, count] : counts) {
    std::string faults;
    for (const auto& [fault, times] : count.faults) faults += fmt::format(" {} {}", fault, times);
    fmt::print("{:34} {:4} runs, {:4} refused, at most {:.2f} of the reference's velocity, {:.3f} in after it;{}\n",
               name, count.runs, count.refused, count.fastest, count.lost_in, faults);
  }
}

/// A number of the file beside the promise, and where it stands.
struct Number {
  std::string name;
  std::size_t begin = 0;
  std::size_t end = 0;
  double value = 0.0;
};

std::vector<Number> numbers_of(const std::string& text) {
  std::vector<Number> numbers;
  std::string table;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    const std::size_t equals = line.find(" = ");
    if (line.starts_with("[")) table = line.substr(1, line.find(']') - 1);
    if (equals != std::string::npos && !table.starts_with("promise") && table != "provenance") {
      const std::string value = line.substr(equals + 3);
      char* stopped = nullptr;
      const double number = std::strtod(value.c_str(), &stopped);
      if (stopped != value.c_str() && line != "schema = 1") {
        numbers.push_back({table + "." + line.substr(0, equals), at + equals + 3,
                           at + equals + 3 + static_cast<std::size_t>(stopped - value.c_str()), number});
      }
    }
    at = end + 1;
  }
  return numbers;
}

TEST(TrackCampaign, NeverStopsASoundRig) {
  Axes axes;
  const int runs = runs_wanted(1000) / kRunsOfAPlant;
  for (int run = 0; run < runs; ++run) {
    Axis axis = axes.of(run * kRunsOfAPlant);
    TrackSource source(trial(axis, axis.controller), axis.rig.limits);
    const Driven did = driven(axis.plant, axis.rig, source, std::nullopt);
    EXPECT_EQ(did.fault, Fault::none) << "plant " << run << ": " << to_text(did.fault) << " at " << did.at_s
                                      << " s, flow " << axis.plant.valve_rated_flow_L_per_min << ", noise "
                                      << axis.plant.sensor_noise_V;
  }
  fmt::print("{} sound rigs\n", runs);
}

/// Set points of a user's: there and back over the travel, nearly as fast as the reference may move.
config::Track cycle(const Axis& axis, double low_in, double high_in, int times) {
  config::Track track = trial(axis, axis.controller);
  const double move_s = 1.2 * (high_in - low_in) / reference_velocity(track) + 0.5;
  std::vector<ident::SetPoint> points;
  for (int k = 0; k < times; ++k) {
    const double from_s = 2.0 * k * (move_s + 0.5);
    points.push_back({from_s, low_in});
    points.push_back({from_s + move_s, high_in});
    points.push_back({from_s + move_s + 0.5, high_in});
    points.push_back({from_s + 2.0 * move_s + 0.5, low_in});
  }
  track.plan.reference = points;
  return track;
}

TEST(TrackCampaign, NeverStopsASoundRigOnSetPointsOverItsTravel) {
  Axes axes;
  const int runs = runs_wanted(200);
  for (int run = 0; run < runs; ++run) {
    const Axis& axis = axes.of(run);
    Random random(30'000 + first_wanted() + static_cast<unsigned>(run));
    hal::SimOptions plant = axis.plant;
    // Warm oil, a lower pressure, a null that has wandered.
    plant.valve_rated_flow_L_per_min *= uniform(random, 0.92, 1.08);
    plant.valve_null_offset_V += uniform(random, -0.01, 0.01);
    plant.seed = random();
    const double low_in = uniform(random, 0.3, 1.5);
    const double high_in = uniform(random, 4.4, 5.6);
    plant.initial_displacement_in = low_in;
    TrackSource source(cycle(axis, low_in, high_in, 1), axis.rig.limits);
    const Driven did = driven(plant, axis.rig, source, std::nullopt);
    EXPECT_EQ(did.fault, Fault::none) << "run " << run << ": " << to_text(did.fault) << " at " << did.at_s << " s, "
                                      << low_in << " to " << high_in << " in";
  }
}

TEST(TrackCampaign, StopsSetPointsOverTheTravelBeforeAnEndStopWhereTheSlopeHasFallen) {
  Axes axes;
  Count count;
  const int runs = runs_wanted(200);
  int met = 0;
  double hardest = 0.0;
  for (int run = 0; run < runs; ++run) {
    const Axis& axis = axes.of(run);
    Random random(40'000 + first_wanted() + static_cast<unsigned>(run));
    hal::SimOptions plant = axis.plant;
    const double low_in = uniform(random, 0.3, 1.0);
    plant.initial_displacement_in = low_in;
    const config::Track track = cycle(axis, low_in, uniform(random, 5.0, 5.6), 1);
    TrackSource source(track, axis.rig.limits);
    const auto moment = static_cast<std::int64_t>(uniform(random, 300.0, 0.7 * source.rows()));
    const double slope = uniform(random, 0.5, 0.8);
    const Driven did = driven(plant, axis.rig, source,
                              hal::InjectedFault{.kind = hal::FaultKind::scaled_sensor,
                                                 .first_tick = moment,
                                                 .ticks = hal::InjectedFault::kAlways,
                                                 .amount = slope});
    ++count.runs;
    ++count.faults[std::string(to_text(did.fault))];
    if (!did.met_end_stop) continue;
    ++met;
    hardest = std::max(hardest, did.fastest_in_per_s);
    fmt::print("run {}, slope {:.3f} at {} ms of {}: {} at {:.1f} s, {:.2f} in/s\n", run, slope, moment, source.rows(),
               to_text(did.fault), did.at_s, did.fastest_in_per_s);
  }
  print({{"slope of 0.5 to 0.8", count}});
  fmt::print("{} met an end stop, in runs of up to {:.2f} in/s\n", met, hardest);
  EXPECT_EQ(count.faults["none"], 0);
  EXPECT_LE(met, runs / 50);
}

TEST(TrackCampaign, IsAbortedNearWhereItWas) {
  constexpr std::array<const char*, 6> kKinds{"stop",          "stuck",        "reversed",
                                              "scale doubled", "slope halved", "offset step"};
  Axes axes;
  std::map<std::string, Count> counts;
  const int runs = runs_wanted(1000);
  for (int run = 0; run < runs; ++run) {
    const Axis& axis = axes.of(run);
    Random random(90'000 + first_wanted() + static_cast<unsigned>(run));
    const config::Track track = trial(axis, axis.controller);
    TrackSource source(track, axis.rig.limits);
    const auto moment = static_cast<std::int64_t>(uniform(random, 200.0, 0.9 * source.rows()));
    const std::size_t kind = static_cast<std::size_t>(run) % kKinds.size();
    hal::InjectedFault fault{.first_tick = moment, .ticks = hal::InjectedFault::kAlways};
    if (kind == 1) fault.kind = hal::FaultKind::stuck_sensor, fault.noise_LSB = uniform(random, 0.0, 20.0);
    if (kind == 2) fault.kind = hal::FaultKind::reversed_sensor;
    if (kind == 3) fault.kind = hal::FaultKind::scaled_sensor, fault.amount = 2.0;
    if (kind == 4) fault.kind = hal::FaultKind::scaled_sensor, fault.amount = 0.5;
    if (kind == 5) fault.kind = hal::FaultKind::spike, fault.amount = uniform(random, 0.2, 0.6);
    hal::SimOptions plant = axis.plant;
    plant.initial_displacement_in = uniform(random, 0.8, 5.1);
    const Driven did =
        kind == 0 ? driven(plant, axis.rig, source, std::nullopt, moment) : driven(plant, axis.rig, source, fault);
    Count& count = counts[kKinds.at(kind)];
    ++count.runs;
    ++count.faults[std::string(to_text(did.fault))];
    count.lost_in = std::max(count.lost_in, did.lost_in);
    count.fastest = std::max(count.fastest, did.fastest_in_per_s / reference_velocity(track));
    const bool goes_on = did.fault == Fault::none && kind != 0;
    const std::string what = fmt::format("run {}, {} at {} ms: {} at {:.2f} s, {:.3f} in", run, kKinds.at(kind), moment,
                                         to_text(did.fault), did.at_s, did.lost_in);
    // A sensor whose slope changes while the rod rests shows nothing, and the trial goes on to its end.
    if (!goes_on) {
      EXPECT_LE(did.lost_in, 0.5) << what;
    }
    EXPECT_FALSE(did.met_end_stop) << what;
  }
  print(counts);
}

TEST(TrackCampaign, KeepsASlipOfThePenSlow) {
  Axes axes;
  std::map<std::string, Count> counts;
  const int runs = runs_wanted(1000);
  for (int run = 0; run < runs; ++run) {
    const Axis& axis = axes.of(run);
    Random random(50'000 + first_wanted() + static_cast<unsigned>(run));
    const std::vector<Number> numbers = numbers_of(axis.controller);
    const Number& number = numbers[static_cast<std::size_t>(below(random, static_cast<int>(numbers.size())))];
    const std::array<double, 3> factors{10.0, 0.1, -1.0};
    const double factor = factors.at(static_cast<std::size_t>(below(random, 3)));
    std::string text = axis.controller;
    text.replace(number.begin, number.end - number.begin, fmt::format("{:#.9g}", factor * number.value));
    Count& count = counts[number.name];
    ++count.runs;
    const double tuned = reference_velocity(trial(axis, axis.controller));
    std::optional<TrackSource> source;
    try {
      source.emplace(trial(axis, text), axis.rig.limits);
    } catch (const ConfigError&) {
      ++count.refused;
      continue;
    }
    const Driven did = driven(axis.plant, axis.rig, *source, std::nullopt);
    ++count.faults[std::string(to_text(did.fault))];
    count.fastest = std::max(count.fastest, did.fastest_in_per_s / tuned);
    const std::string what =
        fmt::format("run {}: {} {:.3g} times {}: {} at {:.2f} s, {:.2f} in/s for {:.2f}", run, number.name,
                    number.value, factor, to_text(did.fault), did.at_s, did.fastest_in_per_s, tuned);
    EXPECT_LE(did.fastest_in_per_s, std::max(1.0, 2.5 * tuned)) << what;
    EXPECT_FALSE(did.met_end_stop) << what;
  }
  print(counts);
}

}  // namespace
}  // namespace eha::track
