// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/tune/tune.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "config/valve_estimate.hpp"
#include "core/error.hpp"
#include "daemon/tune/kind_table.hpp"

namespace eha::tune {
namespace {

using ident::FeedbackKind;

constexpr std::array kShares{1.0, 0.7, 0.5, 0.35, 0.25, 0.15};
constexpr std::size_t kTriedShares =
    3;  // of P and of a kind that was named; the others take the place of one that hunts
constexpr int kFewTwins = 4;
constexpr double kFewHold_s = 6.0;
constexpr double kWiden = 0.25;        // of the twins' range, added on each side: 50 twins do not cover every rig
constexpr double kBetter = 0.8;        // an error below this share of another's counts as better
constexpr double kFaultOfWorst = 4.0;  // following error that is a fault, over the greatest promised one
constexpr double kFaultOfSwings = 2.0;
constexpr double kFreeSwings = 4.0;
constexpr double kSeenTurn = 0.03;  // greatest phase at the crossover of lags too fast for the model [rad]

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

ident::Interval widened(const std::vector<ident::TrialFigures>& trials, double ident::TrialFigures::*member,
                        double least) {
  std::vector<double> values;
  for (const ident::TrialFigures& trial : trials) values.push_back(trial.*member);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double more = std::max(kWiden * (*high - *low), least);
  return {median(values), std::max(0.0, *low - more), *high + more};
}

std::vector<ident::TrialFigures> tried(const std::vector<hal::SimOptions>& twins, const ident::AxisSettings& settings,
                                       const ident::TrialPlan& plan, const ident::Executor& executor) {
  const ident::AxisCoefficients controller = ident::coefficients(settings);
  std::vector<ident::TrialFigures> trials(twins.size());
  executor(twins.size(), [&](std::size_t i) { trials[i] = axis_trial(twins[i], controller, plan); });
  return trials;
}

bool hunts(const ident::TrialFigures& trial, double most_in) { return trial.standing_in > most_in || trial.has_left; }

std::vector<FeedbackKind> kinds_of(const TuneTask& task, const ident::AxisPlant& plant) {
  if (task.kind) return {*task.kind};
  // An integrating rod with a known valve needs no integrator; another plant keeps an error without one.
  if (plant.order_at_zero > 0.5) return {FeedbackKind::p, FeedbackKind::pi, FeedbackKind::pd, FeedbackKind::pid};
  return {FeedbackKind::p, FeedbackKind::pi, FeedbackKind::pid};
}

/// Picks the simplest kind within a fifth of the best error, both following and at rest.
std::size_t chosen(const std::vector<Candidate>& candidates, double rest_allowed_in) {
  double least = std::numeric_limits<double>::infinity();
  const auto cost = [&](const Candidate& c) {
    return c.following_rms_in + std::max(0.0, c.rest_error_in - rest_allowed_in);
  };
  for (const Candidate& c : candidates) {
    if (!c.hunts) least = std::min(least, cost(c));
  }
  std::size_t best = candidates.size();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& c = candidates[i];
    if (c.hunts || kBetter * cost(c) > least) continue;
    if (best == candidates.size() || c.kind < candidates[best].kind ||
        (c.kind == candidates[best].kind && cost(c) < cost(candidates[best]))) {
      best = i;
    }
  }
  return best;
}

/// A PI is a PID without a derivative: if its error is less, because of a shorter filter, it becomes the PID.
std::optional<ident::AxisDesign> better_of(std::optional<ident::AxisDesign> pid, std::optional<ident::AxisDesign> pi) {
  if (!pi || (pid && pid->feedback.squared_error <= pi->feedback.squared_error)) return pid;
  pi->settings.kind = FeedbackKind::pid;
  return pi;
}

std::string remark_on_fractional_orders(double gain) {
  const double percent = std::max(0.0, 100.0 * (1.0 - 1.0 / gain));
  return gain > ident::kFractionalIsWorth
             ? fmt::format(
                   "Fractional orders: a search finds {:.0f} % less error after a sudden load than with the best PI or "
                   "PID of the same margin and noise. `eha tune --kind fopid` shows what they do in the trials.",
                   percent)
             : fmt::format(
                   "Fractional orders are not worth their effort here: {:.0f} % less error after a sudden load than "
                   "with the best PI or PID of the same margin and noise.",
                   percent);
}

/// Why the valve of [following] applies and not that of the model.
std::string following_remark(const ident::AxisPlant& plant) {
  return fmt::format(
      "Null {:.3f} V and half dead band {:.3f} V are those of [following] of the rig file, not the model's {:.3f} and "
      "{:.3f} V: the model's record determines its two less well, or the rod moves within the model's dead band, which "
      "shifts them. --sheet takes those of a new valve sheet instead.",
      plant.valve.null, plant.valve.dead_band, plant.replaced->null, plant.replaced->dead_band);
}

/// What a lasting load does to a controller without an integral, and what an integral costs; empty with one.
std::string remark_on_load(const Tuned& tuned, const DisplayUnit& unit) {
  const ident::Feedback& feedback = tuned.design.settings.feedback;
  if (feedback.ki > 0.0 || !(feedback.kp > 0.0)) return {};
  const std::string in = unit.of("in");
  std::string text = fmt::format(
      "Without an integral a lasting load keeps the rod away: one that would move it at 1 {}/s by {:.3g} {}.", in,
      1.0 / feedback.kp, in);
  const Candidate* best = nullptr;
  const Candidate* own = nullptr;
  for (const Candidate& c : tuned.candidates) {
    if (c.hunts) continue;
    if (c.kind == tuned.design.settings.kind && own == nullptr) own = &c;
    if (c.design.settings.feedback.ki > 0.0 && (best == nullptr || c.following_rms_in < best->following_rms_in))
      best = &c;
  }
  if (best == nullptr || own == nullptr) return text;
  const double factor = unit.factor("in");
  return text +
         fmt::format(" With --kind {} nothing of it stays, and the rod follows within {:.3g} {} (RMS), not {:.3g}.",
                     ident::text(best->kind), factor * best->following_rms_in, in, factor * own->following_rms_in);
}

/// What limits the gain: the trials where a share of the allowed gain serves better, else noise or margin, whichever
/// binds; neither where the least error after a load lies within both.
std::string remark_on_gain(const Tuned& tuned, const TuneTask& task) {
  constexpr double kBinds = 0.97;  // of a limit
  const ident::AxisDesign& d = tuned.design;
  if (tuned.share < 1.0) {
    const bool hunts = std::any_of(tuned.candidates.begin(), tuned.candidates.end(), [&](const Candidate& c) {
      return c.kind == d.settings.kind && c.share > tuned.share && c.hunts;
    });
    return fmt::format(
        "The trials limit the gain, not the margin: with more than {:.0f} % of the gain that the margin allows {} on "
        "drawn rigs. Less friction, a quieter sensor or a null and dead band known better would allow more.",
        100.0 * tuned.share, hunts ? "the rod hunts" : "the error is greater");
  }
  if (d.noise_binds) {
    return "The sensor's noise on the command limits the gain, before the margin: a quieter sensor or a faster valve "
           "slew would allow more.";
  }
  if (d.margins.peak95 > kBinds * task.axis.sensitivity) {
    return "The margin limits the gain: less lag of the valve, a shorter tick or a less uncertain model would allow "
           "more.";
  }
  return fmt::format(
      "Neither margin nor noise limits the gain (max(Ms, Mt) is {:.3g}, allowed {:.3g}): it is that of the least error "
      "after a sudden load.",
      d.margins.peak95, task.axis.sensitivity);
}

/// Why the rod stands off the reference at rest.
std::string remark_on_rest(const Tuned& tuned, const TuneTask& task) {
  const ident::Feedback& feedback = tuned.design.settings.feedback;
  if (feedback.ki > 0.0 || !(feedback.kp > 0.0)) return {};
  const double gain = tuned.design.settings.inverse.gain_positive;
  const double offset = tuned.promise.rest_error_in.value;
  return fmt::format(
      "In the hold the rod stands off the reference, by {:.2g} {} in the middle of the trials: without an integral an "
      "error of the valve's null or dead band, or friction, is only answered by gain times this offset, here {:.2g} V.",
      task.unit.factor("in") * offset, task.unit.of("in"), offset * feedback.kp / gain);
}

void remark(Tuned& tuned, const TuneTask& task, const ident::AxisPlant& plant) {
  const ident::AxisDesign& d = tuned.design;
  auto& lines = tuned.remarks;
  const std::string in = task.unit.of("in");
  const double factor = task.unit.factor("in");
  if (std::string load = remark_on_load(tuned, task.unit); !load.empty()) lines.push_back(std::move(load));
  if (std::string rest = remark_on_rest(tuned, task); !rest.empty()) lines.push_back(std::move(rest));
  lines.push_back(remark_on_gain(tuned, task));
  if (!task.kind) {
    for (const FeedbackKind kind : kinds_of(task, plant)) {
      if (std::none_of(tuned.candidates.begin(), tuned.candidates.end(),
                       [&](const Candidate& c) { return c.kind == kind && !c.hunts; })) {
        lines.push_back(fmt::format("{}: no gain keeps the limits without hunting.", name_of(kind)));
      }
    }
  }
  if (plant.unseen_delay_s * d.margins.crossover_rad_s > kSeenTurn) {
    lines.push_back(
        fmt::format("The model was compared every {:g} s and does not show faster lags; the margins allow {:.2g} s for "
                    "them. The same record fitted with a smaller --decimate, and a controller tuned for "
                    "that model, would allow more gain.",
                    plant.compared_step_s, plant.unseen_delay_s));
  }
  if (plant.replaced) {
    lines.push_back(
        task.valve_of == ValveOrigin::following
            ? following_remark(plant)
            : fmt::format(
                  "The valve sheet has null {:.3f} V and half dead band {:.3f} V, the model {:.3f} and {:.3f} V, "
                  "{:.3f} and {:.3f} V away; the sheet applies, for [following] too. {}",
                  plant.valve.null, plant.valve.dead_band, plant.replaced->null, plant.replaced->dead_band,
                  std::abs(plant.replaced->null - plant.valve.null),
                  std::abs(plant.replaced->dead_band - plant.valve.dead_band),
                  task.is_one_valve
                      ? "A model's numbers are of a fit, which a leak, dry friction and the structure shift."
                      : "Did the valve change between the two?"));
  }
  constexpr double kReachOfNoise = 3.0;
  if (kReachOfNoise * task.axis.noise > tuned.promise.following_worst_in.upper) {
    lines.push_back(fmt::format(
        "The sensor's noise, {:.2g} {} (rms), reaches beyond the promised error of {:.2g} {}: the promise is "
        "of the rod, and a trial may show figures of it as hidden by noise.",
        factor * task.axis.noise, in, factor * tuned.promise.following_worst_in.upper, in));
  }
  if (d.settings.feedback.ki > 0.0) {
    lines.push_back(
        fmt::format("The integral stands still within {:.2g} {} of the reference, where noise and friction "
                    "would make the rod hunt.",
                    factor * d.settings.rest_error, in));
  }
  lines.push_back(
      fmt::format("References move at up to {:.3g} {}/s and {:.3g} {}/s^2: so much the valve gives within the slew, "
                  "the velocity limit "
                  "and closed_loop_max_V of the rig.",
                  factor * d.settings.reference.velocity, in, factor * d.settings.reference.acceleration, in));
  if (!plant.has_covariance) {
    lines.emplace_back("The model file has no covariance: the margins assume 5 % for the gain and 10 % for the lag.");
  }
  if (plant.inverse.error_percent > 10.0) {
    lines.push_back(
        fmt::format("The feed-forward misses the model's inverse by up to {:.0f} % in its band: fast "
                    "references are followed less well.",
                    plant.inverse.error_percent));
  }
}

}  // namespace

double most_standing_in(const ident::AxisTask& task) { return 3.0 * task.noise + task.lsb; }

Tuned tune(const ident::AxisPlant& plant, const TuneTask& task, const ident::Executor& executor) {
  const double most_in = most_standing_in(task.axis);
  const std::vector<hal::SimOptions> twins =
      drawn_twins(task.twin, task.spread, task.axis.lowest, task.axis.highest, task.twins, task.seed);
  const std::vector<hal::SimOptions> few(twins.begin(),
                                         twins.begin() + std::min<std::ptrdiff_t>(kFewTwins, task.twins));

  Tuned tuned;
  std::vector<ident::AxisDesign> designs;
  const std::vector<FeedbackKind> kinds = kinds_of(task, plant);
  std::vector<std::optional<ident::AxisDesign>> found(kinds.size());
  std::optional<double> fractional_gain;
  // The slowest first.
  executor(kinds.size(), [&](std::size_t nth) {
    const std::size_t i = kinds.size() - 1 - nth;
    found[i] = ident::design_axis(plant, task.axis, kinds[i]);
    if (task.kind == FeedbackKind::pid) {
      found[i] = better_of(found[i], ident::design_axis(plant, task.axis, FeedbackKind::pi));
    }
    if (!task.kind && kinds[i] == FeedbackKind::pid && found[i]) {
      fractional_gain = ident::gain_of_fractional_orders(plant, task.axis, *found[i]);
    }
  });
  if (!task.kind) {
    const auto of = [&](FeedbackKind kind) -> std::optional<ident::AxisDesign>& {
      return found.at(static_cast<std::size_t>(std::find(kinds.begin(), kinds.end(), kind) - kinds.begin()));
    };
    std::optional<ident::AxisDesign>& pid = of(FeedbackKind::pid);
    const std::optional<ident::AxisDesign>& pi = of(FeedbackKind::pi);
    if (pid && pi && fractional_gain) {
      *fractional_gain *= std::min(1.0, std::sqrt(pi->feedback.squared_error / pid->feedback.squared_error));
    }
    pid = better_of(pid, pi);
    if (pid && !fractional_gain) fractional_gain = ident::gain_of_fractional_orders(plant, task.axis, *pid);
  }
  for (const auto& design : found) {
    if (!design) continue;
    // Kinds that are only compared are tried with their full gain.
    const bool is_compared = !task.kind && design->settings.kind != kinds.front();
    for (std::size_t i = 0; i < (is_compared ? 1 : kTriedShares); ++i) {
      Candidate c{.kind = design->settings.kind, .share = kShares.at(i)};
      c.design = i == 0 ? *design : ident::with_share(*design, plant, task.axis, c.share);
      if (c.design.margins.peak95 > task.axis.sensitivity) continue;
      ident::TrialPlan plan = ident::trial_plan(c.design.settings);
      plan.hold_s = kFewHold_s;
      plan.trapezoids = 1;
      std::vector<double> following;
      for (const ident::TrialFigures& trial : tried(few, c.design.settings, plan, executor)) {
        following.push_back(trial.following_rms_in);
        c.rest_error_in = std::max(c.rest_error_in, trial.rest_error_in);
        c.standing_in = std::max(c.standing_in, trial.standing_in);
        c.hunts = c.hunts || hunts(trial, most_in);
      }
      c.following_rms_in = median(following);
      tuned.candidates.push_back(c);
    }
  }
  if (tuned.candidates.empty()) {
    throw DataError(
        fmt::format("no feedback keeps max(Ms, Mt) below {:g} and the noise of the command below its limit; "
                    "a quieter sensor, or a model with smaller intervals, would allow one",
                    task.axis.sensitivity));
  }

  const double rest_allowed_in = std::max(2.0 * most_in, 4.0 * task.axis.lsb);
  while (true) {
    const std::size_t at = chosen(tuned.candidates, rest_allowed_in);
    if (at == tuned.candidates.size()) break;
    Candidate& best = tuned.candidates[at];
    ident::TrialPlan plan = ident::trial_plan(best.design.settings);
    plan.hold_s = task.hold_s;
    std::vector<ident::TrialFigures> trials = tried(twins, best.design.settings, plan, executor);
    const auto bad = std::count_if(trials.begin(), trials.end(),
                                   [&](const ident::TrialFigures& trial) { return hunts(trial, most_in); });
    if (bad > 0) {
      best.hunts = true;
      for (const ident::TrialFigures& trial : trials) best.standing_in = std::max(best.standing_in, trial.standing_in);
      tuned.remarks.push_back(fmt::format("{} with kp {:.3g} /s hunts on {} of {} drawn rigs: not offered.",
                                          name_of(best.kind), best.design.settings.feedback.kp, bad, trials.size()));
      // Tries one more with less gain, if this had the least gain of its kind.
      const auto next = std::find_if(kShares.begin(), kShares.end(), [&](double share) { return share < best.share; });
      const bool is_last = std::none_of(tuned.candidates.begin(), tuned.candidates.end(), [&](const Candidate& c) {
        return c.kind == best.kind && c.share < best.share;
      });
      if (is_last && next != kShares.end()) {
        Candidate less{.kind = best.kind, .share = *next};
        less.design = ident::with_share(best.design, plant, task.axis, *next / best.share);
        less.following_rms_in = best.following_rms_in;
        if (less.design.margins.peak95 <= task.axis.sensitivity) tuned.candidates.push_back(less);
      }
      continue;
    }
    tuned.design = best.design;
    tuned.share = best.share;
    tuned.plan = plan;
    tuned.trials = std::move(trials);
    const double noise = task.axis.lsb;
    const auto of = [&](double ident::TrialFigures::*member) { return widened(tuned.trials, member, noise); };
    const ident::MarginIntervals& margins = tuned.design.margins;
    tuned.promise = {.following_rms_in = of(&ident::TrialFigures::following_rms_in),
                     .following_worst_in = of(&ident::TrialFigures::following_worst_in),
                     .sine_rms_in = of(&ident::TrialFigures::sine_rms_in),
                     .overshoot_in = of(&ident::TrialFigures::overshoot_in),
                     .settling_s = widened(tuned.trials, &ident::TrialFigures::settling_s, 10.0 * task.axis.tick_s),
                     .rest_error_in = of(&ident::TrialFigures::rest_error_in),
                     .standing_in = of(&ident::TrialFigures::standing_in),
                     .ms = margins.ms,
                     .mt = margins.mt,
                     .phase_margin_deg = margins.phase_deg,
                     .gain_margin = margins.gain,
                     .delay_margin_s = margins.delay_s};
    tuned.fault.following_error_in =
        kFaultOfWorst * tuned.promise.following_worst_in.upper + 6.0 * task.axis.noise + 2.0 * task.axis.lsb;
    tuned.fault.swing_V = ident::swing_width_V(tuned.design.settings);
    double swings = 0.0;
    for (const ident::TrialFigures& trial : tuned.trials) swings = std::max(swings, trial.swings_per_s);
    tuned.fault.swings_per_s = kFaultOfSwings * swings + kFreeSwings;
    hal::SimOptions shown = task.twin;
    shown.initial_displacement_in = 0.5 * (task.axis.lowest + task.axis.highest);
    ident::TrialPlan short_plan = plan;
    short_plan.hold_s = 5.0;
    static_cast<void>(axis_trial(shown, ident::coefficients(tuned.design.settings), short_plan, &tuned.trace));
    remark(tuned, task, plant);
    if (fractional_gain) tuned.remarks.push_back(remark_on_fractional_orders(*fractional_gain));
    tuned.kinds = kinds_compared(tuned.candidates, plant, fractional_gain);
    return tuned;
  }
  throw DataError(
      fmt::format("every feedback that keeps the limits hunts on a drawn rig (p-p at rest above {:.2g} {}): "
                  "measure null and dead band again with `eha characterise`, or name a fitted twin with --twin",
                  task.unit.factor("in") * most_in, task.unit.of("in")));
}

}  // namespace eha::tune
