// SPDX-License-Identifier: GPL-3.0-or-later
// What a tick costs more with a hold, and with a controller, than with the bare table. Alternating, with medians:
//   hold_bench --benchmark_repetitions=10 --benchmark_enable_random_interleaving=true
//              --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "daemon/acquisition/tick_engine.hpp"
#include "daemon/place/hold_source.hpp"
#include "daemon/track/track_source.hpp"
#include "tests/unit/acquisition/fake_rig.hpp"
#include "tests/unit/acquisition/play.hpp"
#include "tests/unit/acquisition/tracked.hpp"

namespace {

using namespace eha::acquisition;

constexpr std::size_t kRows = 50'000;  // as of paper.toml: the tables do not stay in the first cache
constexpr std::uint32_t kRepetitions = 40'000;
constexpr std::uint32_t kTicksToRunning = 1000;

/// Ticks in state running, on a rig that costs next to nothing.
/// @param first  ticks before those that are measured
void run_ticks(benchmark::State& state, CommandSource& source, std::uint32_t first = kTicksToRunning) {
  FakeRig rig;
  Play play;
  play.machine.reset();
  play.machine.arm();
  TickEngine engine(rig, play.machine, source, play.limits, play.realtime, LatePolicy::abort, play.clock);
  TickInputs inputs;
  const auto tick = [&] {
    play.clock.advance(1'000'000);
    inputs.scheduled_ns += 1'000'000;
    inputs.woken_ns = inputs.scheduled_ns;
    ++inputs.sequence;
    return engine.tick(inputs);
  };
  for (std::uint32_t i = 0; i < first; ++i) tick();
  for (auto _ : state) benchmark::DoNotOptimize(tick());
  if (play.machine.state() != State::running) state.SkipWithError("the run has ended");
}

void tick_without_hold(benchmark::State& state) {
  const std::vector<double> table_V = cosine(kRows);
  TableSource source(table_V, kRepetitions);
  run_ticks(state, source);
}
BENCHMARK(tick_without_hold);

void tick_with_hold(benchmark::State& state) {
  const std::vector<double> table_V = cosine(kRows);
  std::vector<double> predicted_in(kRows);
  for (std::size_t k = 0; k < kRows; ++k) {
    // The integral of the table, as the fake rod moves.
    predicted_in[k] = k == 0 ? 0.0 : predicted_in[k - 1] + 0.001 * table_V[k - 1];
  }
  eha::place::HoldSource source(table_V, predicted_in, kRepetitions, {1.0, 1.0}, eha::place::LoopMonitor({}, 0.001));
  run_ticks(state, source);
}
BENCHMARK(tick_with_hold);

void tick_with_controller(benchmark::State& state) {
  eha::config::RigLimits limits;
  limits.command_min_V = -5.0;
  limits.command_max_V = 5.0;
  eha::track::TrackSource source(tracked(1.0, 1.2, 36'000.0), limits);
  run_ticks(state, source);
}
BENCHMARK(tick_with_controller);

void tick_with_sweep(benchmark::State& state) {
  eha::config::RigLimits limits;
  limits.command_min_V = -5.0;
  limits.command_max_V = 5.0;
  eha::config::Track track = tracked(1.0, 1.2, 36'000.0);
  track.plan.reference.clear();
  track.plan.trapezoids = 0;
  track.plan.sweep = eha::ident::margin_sweep(track.controller.settings, track.plan.step, 0.05);
  track.plan.sweep->ways = 10'000;
  const eha::ident::TrialMotion motion(track.controller.settings, track.plan, 2.95);
  std::uint32_t first = kTicksToRunning;
  while (motion.part(first - kTicksToRunning) != eha::ident::TrialMotion::Part::sweep) ++first;
  eha::track::TrackSource source(track, limits);
  run_ticks(state, source, first + 5000);
}
BENCHMARK(tick_with_sweep);

}  // namespace
