// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/doctor/following_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "core/error.hpp"
#include "daemon/acquisition/following_monitor.hpp"

namespace eha::doctor {
namespace {

constexpr double kFilter_s = 0.05;   // of the following check
constexpr double kSpacing_s = 0.01;  // of the filtered samples that are kept
constexpr std::size_t kWindow = 10;  // samples in a window: 0.1 s
constexpr std::size_t kParts = 10;   // of the jackknife
constexpr double kHalf95 = 2.262;    // half a 95 % interval over a standard error, Student's with kParts - 1
constexpr double kDeadBandMargin_V = 0.05;
constexpr double kGreatestNullError_V = 0.03;
constexpr double kLeastOutside_s = 0.5;
constexpr double kLeastTravel_in = 0.5;
constexpr double kLeastExplained_percent = 90.0;
constexpr int kGrid = 10;  // points to either side of a grid's middle
constexpr double kFinest_V = 0.001;

constexpr const char* kPlay =
    "play one that moves the rod slowly through its null to both sides, such as a sum of sines of 0.1 to 0.5 Hz whose "
    "peak is twice the dead band or more, for 60 s";

/// Filtered volts at a spacing of kSpacing_s and the motion in windows of kWindow of them.
struct Motion {
  std::vector<double> volts;
  std::vector<double> moved_in;  ///< in the window that begins at sample kWindow i
};

Motion filtered(std::span<const double> input, std::span<const double> output, double step_s) {
  const auto every = static_cast<std::size_t>(std::max(1.0, std::round(kSpacing_s / step_s)));
  const double weight = step_s / (kFilter_s + step_s);
  Motion motion;
  std::vector<double> places_in;
  double volts = input.front();
  double place_in = output.front();
  for (std::size_t k = 1; k < output.size(); ++k) {
    // The displacement of a tick answers the voltage before it.
    volts += weight * (input[k - 1] - volts);
    place_in += weight * (output[k] - place_in);
    if (k % every != 0) continue;
    motion.volts.push_back(volts);
    places_in.push_back(place_in);
  }
  for (std::size_t i = 0; i + kWindow < places_in.size(); i += kWindow) {
    motion.moved_in.push_back(places_in[i + kWindow] - places_in[i]);
  }
  return motion;
}

struct Valve {
  double null_V = 0.0;
  double dead_band_V = 0.0;
  std::array<double, 2> gain{};
  double squares = std::numeric_limits<double>::infinity();  ///< sum over the windows [in^2]
};

/// The best gains for a null and a dead band. @param left_out  part of the jackknife; none: all windows count
Valve with_gains(const Motion& motion, double null_V, double dead_band_V, std::optional<std::size_t> left_out) {
  double pp = 0.0;
  double nn = 0.0;
  double py = 0.0;
  double ny = 0.0;
  double yy = 0.0;
  double pn = 0.0;
  const std::size_t windows = motion.moved_in.size();
  for (std::size_t i = 0; i < windows; ++i) {
    if (left_out && i * kParts / windows == *left_out) continue;
    double positive = 0.0;
    double negative = 0.0;
    for (std::size_t k = i * kWindow + 1; k <= (i + 1) * kWindow; ++k) {
      const double command_V = motion.volts[k] - null_V;
      positive += std::max(0.0, command_V - dead_band_V);
      negative += std::max(0.0, -command_V - dead_band_V);
    }
    positive *= kSpacing_s;
    negative *= -kSpacing_s;
    const double moved = motion.moved_in[i];
    pp += positive * positive;
    nn += negative * negative;
    pn += positive * negative;
    py += positive * moved;
    ny += negative * moved;
    yy += moved * moved;
  }
  Valve valve{.null_V = null_V, .dead_band_V = dead_band_V};
  const double determinant = pp * nn - pn * pn;
  if (!(determinant > 1e-12 * pp * nn)) return valve;
  valve.gain = {(py * nn - ny * pn) / determinant, (ny * pp - py * pn) / determinant};
  if (valve.gain[0] <= 0.0 || valve.gain[1] <= 0.0) return valve;
  valve.squares = yy - valve.gain[0] * py - valve.gain[1] * ny;
  return valve;
}

/// Searches a grid about `start` that narrows down.
Valve fit(const Motion& motion, Valve start, double half_width_V, std::optional<std::size_t> left_out) {
  Valve best = with_gains(motion, start.null_V, start.dead_band_V, left_out);
  for (double width_V = half_width_V; width_V > kFinest_V; width_V *= 0.3) {
    const double step_V = width_V / kGrid;
    const Valve middle = best;
    for (int i = -kGrid; i <= kGrid; ++i) {
      for (int j = -kGrid; j <= kGrid; ++j) {
        const double dead_band_V = middle.dead_band_V + j * step_V;
        if (dead_band_V < 0.0) continue;
        const Valve valve = with_gains(motion, middle.null_V + i * step_V, dead_band_V, left_out);
        if (valve.squares < best.squares) best = valve;
      }
    }
  }
  return best;
}

/// Standard error of the null by the jackknife (Efron, 1982).
double null_error(const Motion& motion, const Valve& valve) {
  constexpr double kLocal_V = 0.1;
  std::vector<double> nulls;
  for (std::size_t part = 0; part < kParts; ++part) nulls.push_back(fit(motion, valve, kLocal_V, part).null_V);
  double mean = 0.0;
  for (const double null_V : nulls) mean += null_V / static_cast<double>(kParts);
  double squares = 0.0;
  for (const double null_V : nulls) squares += (null_V - mean) * (null_V - mean);
  return std::sqrt(squares * static_cast<double>(kParts - 1) / static_cast<double>(kParts));
}

[[noreturn]] void refuse(const std::string& why) {
  throw DataError(fmt::format("the run does not determine [following]: {}; {}", why, kPlay));
}

void require_enough(const Motion& motion, const Valve& valve) {
  double up_in = 0.0;
  double down_in = 0.0;
  for (const double moved : motion.moved_in) (moved > 0.0 ? up_in : down_in) += std::abs(moved);
  if (std::min(up_in, down_in) < kLeastTravel_in) {
    refuse(fmt::format("the rod moved {:.2f} in one way and {:.2f} in the other, {} in each way are needed", up_in,
                       down_in, kLeastTravel_in));
  }
  if (!std::isfinite(valve.squares)) refuse("for every null, motion and command differ in sign on at least one side");
  std::array<double, 2> outside_s{};
  for (const double volts : motion.volts) {
    if (volts - valve.null_V > valve.dead_band_V) outside_s[0] += kSpacing_s;
    if (valve.null_V - volts > valve.dead_band_V) outside_s[1] += kSpacing_s;
  }
  if (std::min(outside_s[0], outside_s[1]) < kLeastOutside_s) {
    refuse(fmt::format("the command was beyond the dead band for {:.1f} s above and {:.1f} s below, {} s are needed",
                       outside_s[0], outside_s[1], kLeastOutside_s));
  }
}

/// Tries the rule on the run.
void try_out(FollowingEstimate& estimate, std::span<const double> input, std::span<const double> output,
             double step_s) {
  config::RigLimits limits;
  limits.following = estimate.following;
  acquisition::FollowingMonitor monitor(acquisition::following_rule(limits));
  monitor.begin(0);
  for (std::size_t k = 0; k < output.size(); ++k) {
    const auto at_ns = static_cast<std::int64_t>(std::llround(static_cast<double>(k + 1) * step_s * 1e9));
    static_cast<void>(monitor.check(at_ns, output[k], input[k == 0 ? 0 : k - 1]));
  }
  estimate.peak_missing = monitor.peak_missing();
  estimate.peak_excess = monitor.peak_excess();
  if (std::max(estimate.peak_missing, estimate.peak_excess) >= 1.0) {
    refuse(
        fmt::format("the following check would have stopped this run with these numbers ({:.2f} of the limit missing, "
                    "{:.2f} too much)",
                    estimate.peak_missing, estimate.peak_excess));
  }
}

}  // namespace

FollowingEstimate estimate_following(std::span<const double> input, std::span<const double> output, double step_s) {
  if (input.size() != output.size() || !(step_s > 0.0)) throw DataError("input and output differ in length");
  const Motion motion = filtered(input, output, step_s);
  if (motion.moved_in.size() < kParts) refuse(fmt::format("it has only {} rows", output.size()));
  const auto [lowest, highest] = std::minmax_element(motion.volts.begin(), motion.volts.end());
  const Valve start{.null_V = 0.5 * (*lowest + *highest), .dead_band_V = 0.25 * (*highest - *lowest)};
  const Valve valve = fit(motion, start, 0.5 * (*highest - *lowest), std::nullopt);
  require_enough(motion, valve);
  FollowingEstimate estimate;
  estimate.gain_in_per_V_s = valve.gain;
  estimate.dead_band_V = valve.dead_band_V;
  double mean_in = 0.0;
  for (const double moved : motion.moved_in) mean_in += moved / static_cast<double>(motion.moved_in.size());
  double variance = 0.0;
  for (const double moved : motion.moved_in) variance += (moved - mean_in) * (moved - mean_in);
  estimate.explained_percent = 100.0 * (1.0 - valve.squares / variance);
  if (estimate.explained_percent < kLeastExplained_percent) {
    refuse(fmt::format("valve and rod explain {:.0f} % of the motion, {:.0f} % are needed; is the excitation too fast?",
                       estimate.explained_percent, kLeastExplained_percent));
  }
  estimate.null_error_V = null_error(motion, valve);
  if (estimate.null_error_V > kGreatestNullError_V) {
    refuse(fmt::format("it gives the null as {:.3f} V with a standard error of {:.3f} V, {} V are needed", valve.null_V,
                       estimate.null_error_V, kGreatestNullError_V));
  }
  estimate.following.gain_positive_in_per_V_s = 0.5 * valve.gain[0];
  estimate.following.gain_negative_in_per_V_s = 0.5 * valve.gain[1];
  estimate.following.null_V = valve.null_V;
  estimate.following.dead_band_V = valve.dead_band_V + kDeadBandMargin_V;
  try_out(estimate, input, output, step_s);
  return estimate;
}

std::string to_rig_lines(const FollowingEstimate& estimate) {
  const config::Following& following = estimate.following;
  return fmt::format(
      "[following]\n"
      "gain_positive_in_per_V_s = {:.4g}  # half of the measured {:.4g}\n"
      "gain_negative_in_per_V_s = {:.4g}  # half of the measured {:.4g}\n"
      "null_V = {:.3f}  # +- {:.3f}, half a 95 % interval\n"
      "dead_band_V = {:.3f}  # measured {:.3f}, and {:g} for what varies\n"
      "limit_in = {:g}  # this run came to {:.0f} % of it\n",
      following.gain_positive_in_per_V_s, estimate.gain_in_per_V_s[0], following.gain_negative_in_per_V_s,
      estimate.gain_in_per_V_s[1], following.null_V, kHalf95 * estimate.null_error_V, following.dead_band_V,
      estimate.dead_band_V, kDeadBandMargin_V, following.limit_in,
      100.0 * std::max(estimate.peak_missing, estimate.peak_excess));
}

}  // namespace eha::doctor
