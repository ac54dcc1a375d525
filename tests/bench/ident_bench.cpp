// SPDX-License-Identifier: GPL-3.0-or-later
//
// Cost of simulation and estimation. Every time is also given as a ratio to one pair of Fourier transforms (forward and
// inverse) of the padded length, measured in the same run, because machines differ and this one is shared.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>
#include <utility>

#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/ladder.hpp"
#include "ident/fractional/grunwald_letnikov.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/signal/fft.hpp"

namespace eha::ident {
namespace {

using std::numbers::pi;

const TransferFunction kPlant{{{0.6, 0.0}}, {{0.05, 0.0}, {1.3, 0.9}, {0.8, 1.75}}, 0.0};

Eigen::VectorXd excitation(Eigen::Index samples, double step_s) {
  Eigen::VectorXd u(samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    const double t = 2.0 * pi * step_s * static_cast<double>(k);
    u[k] = 1.9 * std::cos(0.05 * t + 0.3) + 1.6 * std::cos(0.2 * t + 1.9) + 1.5 * std::cos(0.65 * t + 4.2);
  }
  return u;
}

/// Seconds of one forward and one inverse transform of a length that holds twice the samples.
double transform_pair_s(Eigen::Index samples) {
  const RealFft fft(fast_length(2 * static_cast<std::size_t>(samples)));
  std::vector<double> signal(fft.length(), 1.0);
  std::vector<std::complex<double>> spectrum(fft.bins());
  const int rounds = std::max(3, static_cast<int>(2'000'000 / samples));
  const auto begin = std::chrono::steady_clock::now();
  for (int k = 0; k < rounds; ++k) {
    fft.forward(signal, spectrum);
    fft.inverse(spectrum, signal);
    benchmark::DoNotOptimize(signal.data());
  }
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() / rounds;
}

void report_ratio(benchmark::State& state, Eigen::Index samples) {
  state.SetComplexityN(samples);
  // Rates are inverted times: iterations * pair / elapsed, inverted, is the time of one iteration in pairs.
  state.counters["fft_pairs"] = benchmark::Counter(
      transform_pair_s(samples), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

/// Usual lengths, and decades for the fitted exponent.
void over_lengths(benchmark::internal::Benchmark* bench) {
  bench->Arg(500)
      ->Arg(50'000)
      ->RangeMultiplier(10)
      ->Range(1000, 1'000'000)
      ->Complexity()
      ->Unit(benchmark::kMicrosecond);
}

void GrunwaldLetnikov(benchmark::State& state) {
  const Eigen::VectorXd u = excitation(state.range(0), 0.04);
  for (auto _ : state) benchmark::DoNotOptimize(simulate(kPlant, u, 0.04, SimulationMethod::gl1));
  report_ratio(state, state.range(0));
}
BENCHMARK(GrunwaldLetnikov)->Apply(over_lengths);

void ExactWithTables(benchmark::State& state) {
  const Eigen::VectorXd u = excitation(state.range(0), 0.001);
  for (auto _ : state) benchmark::DoNotOptimize(simulate(kPlant, u, 0.001));
  report_ratio(state, state.range(0));
}
BENCHMARK(ExactWithTables)->Apply(over_lengths);

/// One simulation with the record's tables already made, as in a fit.
void Exact(benchmark::State& state) {
  const auto samples = static_cast<std::size_t>(state.range(0));
  const HeldResponse response({samples, 0.001, 0, 1, samples, {}});
  const InputSpectrum input = response.input_spectrum(excitation(state.range(0), 0.001));
  const ResponseRequest request{0, &input};
  for (auto _ : state) {
    benchmark::DoNotOptimize(response.respond(TransferColumns(kPlant, {kPlant.numerator}, {}), 0.0, {&request, 1}));
  }
  report_ratio(state, state.range(0));
}
BENCHMARK(Exact)->Apply(over_lengths);

struct FitCase {
  Record record;
  Comparison comparison;
  StructureOptions structure;
  LinearPart linear;

  FitCase(Eigen::Index samples, double step_s, std::size_t every) {
    record.step_s = step_s;
    record.input = excitation(samples, step_s);
    record.output = simulate(kPlant, record.input, step_s);
    std::mt19937_64 generator(1);
    for (double& y : record.output) y += 1e-3 * (static_cast<double>(generator() >> 11) * 0x1p-53 - 0.5);
    comparison = compare_every(static_cast<std::size_t>(samples), every, 0);
    structure.name = "fo";
    structure.structure = structures::fo();
    linear.numerator.resize(1);
    linear.solve_bias = true;
  }
};

/// K, a2, a0, n2, n1, input bias and initial output together, from the paper's start of the orders.
void run_fit(benchmark::State& state, const FitCase& c) {
  const double duration_s = c.record.step_s * static_cast<double>(c.record.input.size());
  const ComparedRecord compared(c.record, c.comparison, c.comparison.count, {});
  StructureOptions start = c.structure;
  for (const auto& [name, value] : {std::pair{"n2", 1.8}, {"n1", 0.9}, {"a2", 0.6}, {"a0", 0.05}}) {
    start.parameters.push_back({name, {}, value, {}, {}});
  }
  const Parametrisation::Scale scale{duration_s, c.record.step_s, c.record.input.minCoeff(), c.record.input.maxCoeff()};
  const OutputError problem(compared, Parametrisation::search(start, scale), c.linear);
  const Eigen::VectorXd theta = problem.parametrisation().start();
  std::size_t evaluations = 0;
  for (auto _ : state) {
    const LeastSquaresResult result = minimise(problem, theta, {200, 1e-9, 1e-8});
    evaluations = result.work.simulations();
    benchmark::DoNotOptimize(result.point.cost);
  }
  state.counters["evaluations"] = static_cast<double>(evaluations);
  report_ratio(state, c.record.input.size());
}

void FitOfPaperSize(benchmark::State& state) { run_fit(state, FitCase(500, 0.04, 1)); }
BENCHMARK(FitOfPaperSize)->Unit(benchmark::kMillisecond);

void FitAtFullRate(benchmark::State& state) { run_fit(state, FitCase(50'000, 0.001, 40)); }
BENCHMARK(FitAtFullRate)->Unit(benchmark::kMillisecond);

/// The same behind a valve map, from a start as far from the truth in the map as a fit without it leaves.
void run_valve_fit(benchmark::State& state, FitCase c) {
  c.record.output = simulate(kPlant, mapped({-0.2, 0.15, 0.88}, c.record.input), c.record.step_s);
  std::mt19937_64 generator(1);
  for (double& y : c.record.output) y += 1e-3 * (static_cast<double>(generator() >> 11) * 0x1p-53 - 0.5);
  c.structure.structure = structures::behind_valve(structures::fo());
  c.structure.parameters = {{"null", {}, -0.25, {}, {}}, {"dead_band", {}, 0.1, {}, {}}};
  c.linear.solve_bias = false;
  c.linear.solve_ratio = true;
  run_fit(state, c);
}

void ValveFitOfPaperSize(benchmark::State& state) { run_valve_fit(state, FitCase(500, 0.04, 1)); }
BENCHMARK(ValveFitOfPaperSize)->Unit(benchmark::kMillisecond);

void ValveFitAtFullRate(benchmark::State& state) { run_valve_fit(state, FitCase(50'000, 0.001, 40)); }
BENCHMARK(ValveFitAtFullRate)->Unit(benchmark::kMillisecond);

/// All structures of the ladder on a record as long as the demo's, as one thread does them.
void LadderAtFullRate(benchmark::State& state) {
  FitCase c(50'000, 0.001, 40);
  c.record.output = simulate(kPlant, mapped({-0.2, 0.15, 0.88}, c.record.input), c.record.step_s);
  std::mt19937_64 generator(1);
  for (double& y : c.record.output) y += 1e-3 * (static_cast<double>(generator() >> 11) * 0x1p-53 - 0.5);
  FitOptions options;
  options.decimation = 40;
  const PreparedRecord prepared(c.record, options);
  const FitStructure fit_structure = [&](const StructureOptions& asked, const FitOptions& with,
                                         const std::vector<Model>& known) {
    return fit(prepared, asked, with, run_in_order, known);
  };
  for (auto _ : state) benchmark::DoNotOptimize(climb(prepared, {}, options, {}, fit_structure));
}
BENCHMARK(LadderAtFullRate)->Unit(benchmark::kMillisecond);

void TablesAtFullRate(benchmark::State& state) {
  const FitCase c(50'000, 0.001, 40);
  for (auto _ : state) benchmark::DoNotOptimize(ComparedRecord(c.record, c.comparison, c.comparison.count, {}));
}
BENCHMARK(TablesAtFullRate)->Unit(benchmark::kMillisecond);

/// Runs the tasks of a fit on so many threads.
Executor on_threads(std::size_t threads) {
  return [threads](std::size_t count, const std::function<void(std::size_t)>& task) {
    std::atomic<std::size_t> next{0};
    std::vector<std::jthread> pool;
    for (std::size_t t = 0; t < threads; ++t) {
      pool.emplace_back([&] {
        for (std::size_t k = next++; k < count; k = next++) task(k);
      });
    }
  };
}

/// The default fit, global search and intervals included, on one and on two threads.
void GlobalFit(benchmark::State& state) {
  const FitCase c(50'000, 0.001, 40);
  FitOptions options;
  options.decimation = 40;
  const Executor executor = on_threads(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(fit_by_default(PreparedRecord(c.record, options), c.structure, options, executor, {}));
  }
}
BENCHMARK(GlobalFit)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

/// The same with the fits that leave out each term of a free order, which the verdict asks for.
void FitForVerdict(benchmark::State& state) {
  const FitCase c(50'000, 0.001, 40);
  FitOptions options;
  options.decimation = 40;
  const Executor executor = on_threads(static_cast<std::size_t>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(fit(c.record, c.structure, options, executor));
}
BENCHMARK(FitForVerdict)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace eha::ident
