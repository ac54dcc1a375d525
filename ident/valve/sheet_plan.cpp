// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/valve/sheet_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace eha::ident {
namespace {

constexpr double kRest_s = 2.0;
constexpr double kSweeps_s = 60.0;
constexpr double kLongestSweep_s = 20.0;
constexpr double kShortestSweep_s = 4.0;
constexpr double kSweepShare = 0.3;       // of half the command range
constexpr double kBeyondEdgeShare = 0.2;  // the same, beyond the guessed edge
constexpr double kMostShare = 0.8;        // of half the command range: the loop about the middle needs the rest
constexpr double kMostOfTravel = 0.2;
constexpr double kLowest_Hz = 0.8;
constexpr double kLeastBand = 2.0;  // of highest to lowest frequency
constexpr double kSlewShare = 0.9;
constexpr double kMeasured_s = 1.2;
constexpr double kSettling_s = 0.3;
constexpr double kBiasShare = 0.02;  // of half the command range, between the sine and the guessed edge
constexpr int kMostFrequencies = 6;
constexpr int kFewestFrequencies = 3;

struct Planner {
  const SheetLimits& limits;
  const ValveGuess& guess;
  double half_range_V = 0.5 * (limits.command_max_V - limits.command_min_V);

  [[nodiscard]] Eigen::Index rows_of(double time_s) const {
    return static_cast<Eigen::Index>(std::llround(time_s / limits.step_s));
  }

  [[nodiscard]] double bias_V(double amplitude_V) const {
    return guess.edge_V + amplitude_V + kBiasShare * half_range_V;
  }

  /// Returns the highest frequency at which an amplitude can be played; 0: none.
  [[nodiscard]] double highest_Hz(double amplitude_V) const {
    const double peak_V = bias_V(amplitude_V) + amplitude_V;
    if (std::abs(guess.null_V) + peak_V > kMostShare * half_range_V) return 0.0;
    const double way_in = guess.gain_in_per_V_s.value_or(0.0) * bias_V(amplitude_V) * (kMeasured_s + kSettling_s);
    if (way_in > kMostOfTravel * limits.travel_in) return 0.0;
    const double by_slew = kSlewShare * limits.slew_V_per_s / (2.0 * std::numbers::pi * amplitude_V);
    const double highest = std::min(by_slew, 0.05 / limits.step_s);
    return highest >= kLeastBand * kLowest_Hz ? highest : 0.0;
  }

  /// Plans the sines one after the other. @param first  row where they begin
  [[nodiscard]] std::vector<SineSegment> sines(Eigen::Index first, int frequencies, Eigen::Index& end) const {
    std::vector<SineSegment> segments;
    Eigen::Index row = first;
    for (std::size_t level = 0; level < kSheetAmplitudes.size(); ++level) {
      const double amplitude_V = kSheetAmplitudes[level] * half_range_V;
      const double highest = highest_Hz(amplitude_V);
      if (highest <= 0.0) continue;
      const double settling_s = kSettling_s + 2.0 * bias_V(amplitude_V) / limits.slew_V_per_s;
      for (int i = 0; i < frequencies; ++i) {
        const double wanted_Hz = kLowest_Hz * std::pow(highest / kLowest_Hz, i / (frequencies - 1.0));
        const double periods = std::ceil(kMeasured_s * wanted_Hz - 1e-9);
        const Eigen::Index rows = rows_of(periods / wanted_Hz);
        for (const double side : {1.0, -1.0}) {
          row += rows_of(settling_s);
          segments.push_back({.level = level,
                              .first = row,
                              .rows = rows,
                              .frequency_Hz = periods / (static_cast<double>(rows) * limits.step_s),
                              .amplitude_V = amplitude_V,
                              .bias_V = side * bias_V(amplitude_V)});
          row += rows;
        }
      }
    }
    end = row;
    return segments;
  }

  /// Amplitude of the triangles [V].
  [[nodiscard]] double sweep_V() const {
    return std::clamp(guess.edge_V + kBeyondEdgeShare * half_range_V, kSweepShare * half_range_V,
                      kMostShare * half_range_V);
  }

  /// Triangles in kSweeps_s. In one the rod moves by gain (sweep - edge)^2 period / (4 sweep).
  [[nodiscard]] int sweeps() const {
    double period_s = kLongestSweep_s;
    if (guess.gain_in_per_V_s) {
      const double way_in_per_s = *guess.gain_in_per_V_s * sweep_V() / 4.0;
      period_s = std::min(period_s, kMostOfTravel * limits.travel_in / way_in_per_s);
    }
    return static_cast<int>(std::ceil(kSweeps_s / std::max(period_s, kShortestSweep_s) - 1e-9));
  }
};

}  // namespace

SheetPlan sheet_plan(const SheetLimits& limits, const ValveGuess& guess) {
  const Planner planner{limits, guess};
  SheetPlan plan;
  const Eigen::Index rows = planner.rows_of(kSheetDuration_s);
  plan.table_V = Eigen::VectorXd::Constant(rows, guess.null_V);
  plan.rest_rows = planner.rows_of(kRest_s);
  plan.sweep_first = plan.rest_rows;
  plan.sweep_rows = planner.rows_of(kSweeps_s);
  const double sweep_V = planner.sweep_V();
  const int sweeps = planner.sweeps();
  for (Eigen::Index k = 0; k < plan.sweep_rows; ++k) {
    const double turns = static_cast<double>(k) * sweeps / static_cast<double>(plan.sweep_rows);
    const double phase = turns + 0.25 - std::floor(turns + 0.25);  // a triangle that begins at 0, upwards
    plan.table_V[plan.sweep_first + k] += sweep_V * (4.0 * std::min(phase, 1.0 - phase) - 1.0);
  }
  const Eigen::Index sines_first = plan.sweep_first + plan.sweep_rows;
  Eigen::Index end = rows + 1;
  for (int frequencies = kMostFrequencies; frequencies >= kFewestFrequencies && end > rows; --frequencies) {
    plan.sines = planner.sines(sines_first, frequencies, end);
  }
  if (end > rows) plan.sines.clear();  // so slow a slew limit leaves no time
  Eigen::Index from = sines_first;
  for (const SineSegment& sine : plan.sines) {
    for (Eigen::Index k = from; k < sine.first + sine.rows; ++k) {
      const double time_s = static_cast<double>(k - sine.first) * limits.step_s;
      plan.table_V[k] += sine.bias_V + sine.amplitude_V * std::sin(2.0 * std::numbers::pi * sine.frequency_Hz * time_s);
    }
    from = sine.first + sine.rows;
    plan.highest_Hz[sine.level] = std::max(plan.highest_Hz[sine.level], sine.frequency_Hz);
  }
  return plan;
}

}  // namespace eha::ident
