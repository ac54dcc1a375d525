// SPDX-License-Identifier: GPL-3.0-or-later
// Two tanks that empty through orifices, the upper one into the lower one, whose level is the output. Of levels x1, x2
// above the bottom, the upper one scaled to the lower one's area:
//   x1' = q + gain v - k1 sqrt x1, x2' = k1 sqrt x1 - k2 sqrt x2.
// At v = 0 both are at rest at the reference: x2 = level, and each tank has the time constant upper_s or lower_s for
// small motions, T = 2 x / q. The states are the heights above the reference, that of the lower tank first. With
// overflow a tank keeps no more than `top` or `upper_top` above the reference, and the share `spill` of what the upper
// one spills falls into the lower one.
// For small motions it is gain lower_s / ((upper_s s + 1)(lower_s s + 1)).
#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/grey_box/grey_box_kind.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kInflowGain = 0;
constexpr std::size_t kUpper = 1;
constexpr std::size_t kLower = 2;
constexpr std::size_t kLevel = 3;
constexpr std::size_t kTop = 4;
constexpr std::size_t kUpperTop = 5;
constexpr std::size_t kSpill = 6;
constexpr std::array kOverflowParameters{GreyBoxParameter{"gain", GreyBoxUnit::rate_gain, false},
                                         GreyBoxParameter{"upper_s", GreyBoxUnit::seconds},
                                         GreyBoxParameter{"lower_s", GreyBoxUnit::seconds},
                                         GreyBoxParameter{"level", GreyBoxUnit::output},
                                         GreyBoxParameter{"top", GreyBoxUnit::output},
                                         GreyBoxParameter{"upper_top", GreyBoxUnit::output},
                                         GreyBoxParameter{"spill", GreyBoxUnit::none}};
constexpr std::span kOutflowParameters = std::span(kOverflowParameters).first<4>();

constexpr double kStepsATimeConstant = 8.0;   // of the integration, which then errs by 1e-6 of a motion
constexpr double kMostSteps = 16.0;           // a call
constexpr double kQuick = 0.1;                // of a call: the level of a faster tank has settled at its end
constexpr double kLeast = 1e-6;               // of a time constant, as one of 0 has no level
constexpr int kMostEvents = 4;                // instants of a call at which a tank becomes full
constexpr int kEventRounds = 3;               // of the secant that finds one
constexpr double kFull = 1e-9;                // relative
constexpr double kRounding = 1e-12;           // of a call's time
constexpr std::array kLevels{0.5, 1.0, 2.0};  // times the output's range, for starts
constexpr std::array kUpperTops{0.7, 1.5};

struct Tanks {
  double gain = 0.0;
  double flow = 0.0;  // through both at the reference
  double k1 = 0.0;
  double k2 = 0.0;
  double upper = 0.0;  // level of the upper tank at the reference
  double lower = 0.0;
  double upper_top = std::numeric_limits<double>::infinity();  // above the bottom, as the next
  double lower_top = std::numeric_limits<double>::infinity();
  double spill = 0.0;
  // Against the duration of a call: the level of a quick tank settles within it.
  bool is_upper_quick = false;
  bool is_lower_quick = false;
};

/// @param duration_s  of a call
Tanks tanks_of(const double* values, bool overflows, double duration_s) {
  const double shortest_s = kLeast * std::max({values[kUpper], values[kLower], duration_s});
  Tanks t;
  t.is_upper_quick = values[kUpper] < kQuick * duration_s;
  t.is_lower_quick = values[kLower] < kQuick * duration_s;
  t.gain = values[kInflowGain];
  t.lower = values[kLevel];
  t.flow = 2.0 * t.lower / std::max(values[kLower], shortest_s);
  t.upper = 0.5 * t.flow * std::max(values[kUpper], shortest_s);
  t.k1 = t.flow / std::sqrt(t.upper);
  t.k2 = t.flow / std::sqrt(t.lower);
  if (!overflows) return t;
  t.lower_top = t.lower + values[kTop];
  t.upper_top = t.upper + values[kUpperTop];
  t.spill = values[kSpill];
  return t;
}

struct Levels {
  double upper = 0.0;
  double lower = 0.0;
};

Levels rates(const Tanks& t, double v, const Levels& x) {
  const double through = t.k1 * std::sqrt(std::max(x.upper, 0.0));
  Levels rate{t.flow + t.gain * v - through, through - t.k2 * std::sqrt(std::max(x.lower, 0.0))};
  if (x.upper >= t.upper_top && rate.upper > 0.0) {
    rate.lower += t.spill * rate.upper;
    rate.upper = 0.0;
  }
  if (t.is_upper_quick) rate.upper = 0.0;  // it has settled
  if (t.is_lower_quick) rate.lower = 0.0;  // it settles in the end
  if (x.lower >= t.lower_top) rate.lower = std::min(rate.lower, 0.0);
  return rate;
}

/// A step of Runge and Kutta of fourth order.
Levels stepped(const Tanks& t, double v, const Levels& x, double h) {
  const auto moved = [&](double by, const Levels& rate) {
    return Levels{x.upper + by * rate.upper, x.lower + by * rate.lower};
  };
  const Levels a = rates(t, v, x);
  const Levels b = rates(t, v, moved(0.5 * h, a));
  const Levels c = rates(t, v, moved(0.5 * h, b));
  const Levels d = rates(t, v, moved(h, c));
  return {x.upper + h / 6.0 * (a.upper + 2.0 * b.upper + 2.0 * c.upper + d.upper),
          x.lower + h / 6.0 * (a.lower + 2.0 * b.lower + 2.0 * c.lower + d.lower)};
}

/// Share of a step after which one of the tanks is full, at most 1.
double share_until_full(const Tanks& t, const Levels& from, const Levels& to) {
  const auto share = [](double before, double after, double top) {
    return before < top && after > top ? (top - before) / (after - before) : 1.0;
  };
  return std::min(share(from.upper, to.upper, t.upper_top), share(from.lower, to.lower, t.lower_top));
}

/// Without the bounds, so that a step sees its tanks fill up smoothly.
Tanks unbounded_above(const Tanks& t, const Levels& x) {
  Tanks open = t;
  if (x.upper < t.upper_top) open.upper_top = std::numeric_limits<double>::infinity();
  if (x.lower < t.lower_top) open.lower_top = std::numeric_limits<double>::infinity();
  return open;
}

/// The level at which as much flows out as in.
double settled(double inflow, double k, double top) {
  const double root = std::max(0.0, inflow) / k;
  return std::min(root * root, top);
}

/// What flows into the lower tank.
double into_lower(const Tanks& t, double v, double upper) {
  const double through = t.k1 * std::sqrt(upper);
  return through + (upper >= t.upper_top ? t.spill * std::max(0.0, t.flow + t.gain * v - through) : 0.0);
}

/// Steps end where a tank becomes full; one that is full or empty stays within its bounds.
void integrate(const Tanks& t, double* state, double v, double duration_s, double steps) {
  Levels x{state[1] + t.upper, state[0] + t.lower};
  if (t.is_upper_quick) {
    // What it held more, or less, than it settles at goes into the lower one at once.
    const double level = settled(t.flow + t.gain * v, t.k1, t.upper_top);
    if (!t.is_lower_quick) x.lower = std::clamp(x.lower + x.upper - level, 0.0, t.lower_top);
    x.upper = level;
  }
  const double step_s = duration_s / steps;
  double left_s = duration_s;
  for (int k = 0; k < static_cast<int>(kMostSteps) + kMostEvents && left_s > kRounding * duration_s; ++k) {
    double h = std::min(step_s, left_s);
    const Tanks open = unbounded_above(t, x);
    Levels to = stepped(open, v, x, h);
    for (int round = 0; round < kEventRounds; ++round) {
      const double share = share_until_full(t, x, to);
      if (share >= 1.0) break;
      h *= share;
      to = stepped(open, v, x, h);
    }
    const bool fills_upper = x.upper < t.upper_top && to.upper > t.upper_top * (1.0 - kFull);
    const bool fills_lower = x.lower < t.lower_top && to.lower > t.lower_top * (1.0 - kFull);
    x.upper = fills_upper ? t.upper_top : std::clamp(to.upper, 0.0, t.upper_top);
    x.lower = fills_lower ? t.lower_top : std::clamp(to.lower, 0.0, t.lower_top);
    left_s -= h;
  }
  if (t.is_lower_quick) x.lower = settled(into_lower(t, v, x.upper), t.k2, t.lower_top);
  state[0] = x.lower - t.lower;
  state[1] = x.upper - t.upper;
}

/// Of the integration; a quick tank needs none.
double steps_of(const double* values, double duration_s) {
  double shortest_s = duration_s * kStepsATimeConstant;
  for (const std::size_t tank : {kUpper, kLower}) {
    if (values[tank] >= kQuick * duration_s) shortest_s = std::min(shortest_s, values[tank]);
  }
  return std::clamp(std::ceil(duration_s * kStepsATimeConstant / shortest_s), 1.0, kMostSteps);
}

void advance_outflow(const double* values, double* state, double v, double duration_s) {
  integrate(tanks_of(values, false, duration_s), state, v, duration_s, steps_of(values, duration_s));
}

void advance_overflow(const double* values, double* state, double v, double duration_s) {
  integrate(tanks_of(values, true, duration_s), state, v, duration_s, steps_of(values, duration_s));
}

/// Both levels at which as much flows out as in.
void settle(const Tanks& t, double v, double* state) {
  const double upper = settled(t.flow + t.gain * v, t.k1, t.upper_top);
  state[0] = settled(into_lower(t, v, upper), t.k2, t.lower_top) - t.lower;
  state[1] = upper - t.upper;
}

void outflow_at_rest(const double* values, double v, double* state) { settle(tanks_of(values, false, 0.0), v, state); }

void overflow_at_rest(const double* values, double v, double* state) { settle(tanks_of(values, true, 0.0), v, state); }

LinearForm small_motions(std::span<const double> values) {
  const double upper_s = values[kUpper];
  const double lower_s = values[kLower];
  return {values[kInflowGain] * lower_s, {1.0, upper_s + lower_s, upper_s * lower_s}};
}

std::vector<std::vector<double>> outflow_starts(const GreyBoxStart& start) {
  const auto& a = start.linear.denominator;
  const double sum_s = a[1] / a[0];
  const double root_s = std::sqrt(std::max(0.0, 0.25 * sum_s * sum_s - a[2] / a[0]));
  const double long_s = 0.5 * sum_s + root_s;
  const double short_s = std::max(0.5 * sum_s - root_s, 0.05 * sum_s);
  const double range = start.greatest_out - start.lowest_out;
  std::vector<std::vector<double>> all;
  for (const double level : kLevels) {
    for (const auto& [upper_s, lower_s] :
         {std::pair(long_s, short_s), std::pair(short_s, long_s), std::pair(0.5 * sum_s, 0.5 * sum_s)}) {
      all.push_back({start.linear.gain / a[0] / lower_s, upper_s, lower_s, level * range});
    }
  }
  return all;
}

std::vector<std::vector<double>> overflow_starts(const GreyBoxStart& start) {
  const double range = start.greatest_out - start.lowest_out;
  std::vector<std::vector<double>> all;
  for (const std::vector<double>& plain : outflow_starts(start)) {
    for (const double upper_top : kUpperTops) {
      std::vector<double> values = plain;
      values.insert(values.end(), {std::max(start.greatest_out, 0.1 * range), upper_top * range, 0.5});
      all.push_back(std::move(values));
    }
  }
  return all;
}

}  // namespace

const GreyBoxKind& outflow_kind() {
  static const GreyBoxKind kKind{.name = "outflow",
                                 .formula = "two tanks with orifices",
                                 .effect = "an outflow that grows as the root of the level",
                                 .parameters = kOutflowParameters,
                                 .states = 2,
                                 .estimates_start = true,
                                 .bias_is_reference = true,
                                 .advance = advance_outflow,
                                 .at_rest = outflow_at_rest,
                                 .linearised = small_motions,
                                 .starts = outflow_starts};
  return kKind;
}

const GreyBoxKind& overflow_kind() {
  static const GreyBoxKind kKind{.name = "overflow",
                                 .formula = "two tanks with orifices that overflow",
                                 .effect = "tanks that overflow",
                                 .parameters = kOverflowParameters,
                                 .states = 2,
                                 .estimates_start = true,
                                 .bias_is_reference = true,
                                 .advance = advance_overflow,
                                 .at_rest = overflow_at_rest,
                                 .linearised = small_motions,
                                 .starts = overflow_starts};
  return kKind;
}

}  // namespace eha::ident
