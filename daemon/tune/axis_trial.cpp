// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/axis_trial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "hal/converter.hpp"
#include "hal/sim/cylinder.hpp"
#include "hal/sim/normal_noise.hpp"

namespace eha::tune {
namespace {

constexpr double kInchPerMetre = 1.0 / 0.0254;
constexpr double kSettle_s = 1.0;  // after each move
constexpr double kHoldLeftOut_s = 2.0;
constexpr double kSettledShare = 0.02;  // of the step
constexpr double kTraced_s = 10.0;      // of the hold
constexpr int kSines = 2;

/// A controller on a simulated cylinder between its converters.
class Bench {
 public:
  Bench(const hal::SimOptions& o, const ident::AxisCoefficients& controller)
      : options_(o),
        cylinder_(o),
        output_(o.command_min_V, o.command_max_V, o.resolution_bits),
        input_(o.feedback_min_V, o.feedback_max_V, o.resolution_bits),
        noise_(o.seed),
        controller_(controller),
        swings_(controller.settings.inverse.null, swing_width_V(controller.settings), controller.settings.tick_s),
        tick_s_(controller.settings.tick_s) {
    controller_.start(read(), 0.0);
  }

  struct Row {
    ident::AxisOutput out;
    double rod_in = 0.0;
    double error_in = 0.0;  ///< of the rod
  };

  Row tick(double set_point_in) {
    Row row;
    row.rod_in = rod_in();
    row.out = controller_.step(set_point_in, read());
    row.error_in = row.out.reference - row.rod_in;
    const double applied_V = output_.volts(output_.code(row.out.command));
    cylinder_.advance_implicitly(applied_V, hal::Ports::open, tick_s_);
    most_swings_ = std::max(most_swings_, swings_.step(row.out.command));
    ++ticks_;
    limited_ += row.out.is_limited ? 1 : 0;
    return row;
  }

  [[nodiscard]] double rod_in() const { return cylinder_.state().displacement_m * kInchPerMetre; }
  [[nodiscard]] double tick_s() const { return tick_s_; }
  [[nodiscard]] int most_swings() const { return most_swings_; }
  [[nodiscard]] double limited_percent() const { return 100.0 * limited_ / std::max<double>(1.0, ticks_); }

 private:
  double read() {
    const double exact_V = (rod_in() - options_.offset_in) / options_.scale_in_per_V;
    return options_.offset_in +
           options_.scale_in_per_V * input_.volts(input_.code(exact_V + options_.sensor_noise_V * noise_()));
  }

  hal::SimOptions options_;
  hal::Cylinder cylinder_;
  hal::Converter output_;
  hal::Converter input_;
  hal::NormalNoise noise_;
  ident::AxisController controller_;
  SwingCounter swings_;
  double tick_s_;
  int most_swings_ = 0;
  double ticks_ = 0.0;
  double limited_ = 0.0;
};

/// How long a move of the reference takes at most [s].
double move_s(const ident::ReferenceLimits& limits, double way_in) {
  return std::abs(way_in) / limits.velocity + limits.velocity / limits.acceleration +
         2.0 * std::sqrt(std::abs(way_in) / limits.acceleration) + 4.0 * limits.acceleration / limits.jerk;
}

}  // namespace

int SwingCounter::step(double command_V) noexcept {
  now_s_ += tick_s_;
  const double off_V = command_V - null_V_;
  const int side = off_V > width_V_ ? 1 : off_V < -width_V_ ? -1 : 0;
  if (side != 0 && side != side_) {
    if (side_ != 0) {
      if (count_ == kMost) {
        first_ = (first_ + 1) % kMost;
        --count_;
      }
      at_s_[(first_ + count_) % kMost] = now_s_;
      ++count_;
    }
    side_ = side;
  }
  while (count_ > 0 && now_s_ - at_s_[first_] > 1.0) {
    first_ = (first_ + 1) % kMost;
    --count_;
  }
  return count_;
}

double swing_width_V(const ident::AxisSettings& s) {
  return 0.5 * s.inverse.dead_band + s.inverse.steepest() * s.feedback.kp * s.rest_error;
}

TrialPlan trial_plan(const ident::AxisSettings& settings) {
  const ident::ReferenceLimits& limits = settings.reference;
  const double travel = limits.highest - limits.lowest;
  TrialPlan plan;
  plan.lowest_in = limits.lowest;
  plan.highest_in = limits.highest;
  plan.step_in = std::min(0.5, 0.1 * travel);
  plan.sine_in = std::min(0.2, 0.04 * travel);
  const double w = std::min(0.5 * limits.velocity / plan.sine_in, std::sqrt(0.5 * limits.acceleration / plan.sine_in));
  plan.sine_Hz = w / (2.0 * std::numbers::pi);
  return plan;
}

TrialFigures axis_trial(const hal::SimOptions& options, const ident::AxisCoefficients& controller,
                        const TrialPlan& plan, TrialTrace* trace) {
  const ident::AxisSettings& s = controller.settings;
  TrialFigures figures;
  Bench bench(options, controller);
  double now_s = 0.0;
  const auto keep = [&](const Bench::Row& row) {
    if (trace != nullptr) {
      trace->time_s.push_back(now_s);
      trace->reference_in.push_back(row.out.reference);
      trace->rod_in.push_back(row.rod_in);
      trace->command_V.push_back(row.out.command);
    }
    now_s += bench.tick_s();
    figures.has_left = figures.has_left || row.rod_in < plan.lowest_in - 0.5 || row.rod_in > plan.highest_in + 0.5;
    return row;
  };
  const auto play = [&](double duration_s, auto set_point, auto use) {
    const auto ticks = static_cast<int>(std::ceil(duration_s / bench.tick_s()));
    for (int i = 0; i < ticks; ++i) use(i * bench.tick_s(), keep(bench.tick(set_point(i * bench.tick_s()))));
  };
  const double home = std::clamp(options.initial_displacement_in, plan.lowest_in, plan.highest_in);
  // Towards the middle of the travel.
  const double way = home < 0.5 * (plan.lowest_in + plan.highest_in) ? plan.step_in : -plan.step_in;
  const double move = move_s(s.reference, way) + kSettle_s;
  const auto ignore = [](double, const Bench::Row&) {};

  play(
      kSettle_s, [&](double) { return home; }, ignore);

  // Step.
  double ended_s = -1.0;
  double settled_s = 0.0;
  play(
      move, [&](double) { return home + way; },
      [&](double t, const Bench::Row& row) {
        figures.overshoot_in = std::max(figures.overshoot_in, std::copysign(1.0, way) * (row.rod_in - home - way));
        const bool has_ended = std::abs(row.out.reference - home - way) < 1e-6 * std::abs(way);
        if (has_ended && ended_s < 0.0) ended_s = settled_s = t;
        if (ended_s >= 0.0 && std::abs(row.rod_in - home - way) > kSettledShare * std::abs(way)) settled_s = t;
      });
  figures.settling_s = ended_s < 0.0 ? move : settled_s - ended_s;

  // Trapezoids.
  double square = 0.0;
  double rows = 0.0;
  for (int i = 0; i < 2 * plan.trapezoids; ++i) {
    play(
        move, [&](double) { return i % 2 == 0 ? home : home + way; },
        [&](double, const Bench::Row& row) {
          square += row.error_in * row.error_in;
          rows += 1.0;
          figures.following_worst_in = std::max(figures.following_worst_in, std::abs(row.error_in));
        });
  }
  figures.following_rms_in = rows > 0.0 ? std::sqrt(square / rows) : 0.0;

  // Sine about where the rod is, beginning smoothly: its first period only leads in.
  const double centre = home + way;
  const double side = way > 0.0 ? 1.0 : -1.0;
  square = rows = 0.0;
  const double period_s = 1.0 / plan.sine_Hz;
  play((kSines + 1) * period_s,
       [&](double t) {
         return centre + side * plan.sine_in * 0.5 * (1.0 - std::cos(2.0 * std::numbers::pi * t / period_s));
       },
       [&](double t, const Bench::Row& row) {
         if (t < period_s) return;
         square += row.error_in * row.error_in;
         rows += 1.0;
       });
  figures.sine_rms_in = rows > 0.0 ? std::sqrt(square / rows) : 0.0;
  play(
      kSettle_s, [&](double) { return centre; }, ignore);

  // Hold.
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  double last = bench.rod_in();
  TrialTrace* const kept = trace;
  play(
      plan.hold_s, [&](double) { return centre; },
      [&](double t, const Bench::Row& row) {
        if (t > kTraced_s) trace = nullptr;
        if (t < std::min(kHoldLeftOut_s, 0.5 * plan.hold_s)) return;
        low = std::min(low, row.rod_in);
        high = std::max(high, row.rod_in);
        figures.rest_error_in = std::max(figures.rest_error_in, std::abs(row.error_in));
        figures.travelled_in += std::abs(row.rod_in - last);
        last = row.rod_in;
      });
  trace = kept;
  figures.standing_in = high > low ? high - low : 0.0;
  figures.swings_per_s = bench.most_swings();
  figures.limited_percent = bench.limited_percent();
  return figures;
}

}  // namespace eha::tune
