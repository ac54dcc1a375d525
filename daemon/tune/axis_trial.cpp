// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/axis_trial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/inch.hpp"
#include "hal/converter.hpp"
#include "hal/sim/cylinder.hpp"
#include "hal/sim/normal_noise.hpp"

namespace eha::tune {
namespace {

constexpr double kInchPerMetre = 1.0 / kMetrePerInch;
constexpr double kTraced_s = 10.0;  // of the hold
constexpr double kLeft_in = 0.5;    // beyond the travel

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
        swings_(controller.settings.inverse.null, ident::swing_width_V(controller.settings),
                controller.settings.tick_s),
        tick_s_(controller.settings.tick_s) {
    controller_.start(read(), 0.0);
  }

  struct Row {
    ident::AxisOutput out;
    double rod_in = 0.0;
  };

  Row tick(double set_point_in) {
    Row row;
    row.rod_in = rod_in();
    row.out = controller_.step(set_point_in, read());
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
  ident::SwingCounter swings_;
  double tick_s_;
  int most_swings_ = 0;
  double ticks_ = 0.0;
  double limited_ = 0.0;
};

}  // namespace

ident::TrialFigures axis_trial(const hal::SimOptions& options, const ident::AxisCoefficients& controller,
                               const ident::TrialPlan& plan, TrialTrace* trace) {
  const ident::TrialMotion motion(controller.settings, plan, options.initial_displacement_in);
  Bench bench(options, controller);
  ident::TrialScore score(motion);
  bool has_left = false;
  const double tick_s = bench.tick_s();
  for (std::size_t row = 0; row < motion.rows(); ++row) {
    const Bench::Row now = bench.tick(motion.set_point(row));
    score.take(row, now.out.reference, now.rod_in);
    has_left = has_left || now.rod_in < plan.lowest - kLeft_in || now.rod_in > plan.highest + kLeft_in;
    if (trace == nullptr) continue;
    if (motion.part(row) == ident::TrialMotion::Part::hold &&
        static_cast<double>(motion.since(row)) * tick_s > kTraced_s) {
      continue;
    }
    trace->time_s.push_back(static_cast<double>(row) * tick_s);
    trace->reference_in.push_back(now.out.reference);
    trace->rod_in.push_back(now.rod_in);
    trace->command_V.push_back(now.out.command);
  }
  ident::TrialFigures figures = score.figures();
  figures.swings_per_s = bench.most_swings();
  figures.limited_percent = bench.limited_percent();
  figures.has_left = has_left;
  return figures;
}

}  // namespace eha::tune
