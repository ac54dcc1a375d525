// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/tone_grid.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "ident/signal/periods.hpp"

namespace eha::config {
namespace {

/// Tolerance for the rounding of decimals, of a cycle.
constexpr double kCycleTolerance = 1e-6;

/// Whether what is used of one repetition holds two common periods of all tones: they are measured there.
bool repeats_within(const ExperimentConfig& experiment, const std::vector<ident::Tone>& tones) {
  constexpr double kTick_s = 1e-3;  // the usual one; the fit knows the rig's
  std::vector<double> lines_Hz;
  for (const ident::Tone& tone : tones) {
    if (tone.frequency_Hz > 0.0) lines_Hz.push_back(tone.frequency_Hz);
  }
  std::sort(lines_Hz.begin(), lines_Hz.end());
  const double used_s = 0.5 * (experiment.duration_s - experiment.fit.discard_s);
  return used_s > 0.0 && ident::common_period(lines_Hz, kTick_s, static_cast<std::size_t>(used_s / kTick_s + 0.5)) > 0;
}

}  // namespace

std::optional<std::string> off_grid_tones(const ExperimentConfig& experiment) {
  const bool repeats = experiment.repetitions > 1;
  const double period_s = repeats ? experiment.duration_s : 0.5 * (experiment.duration_s - experiment.fit.discard_s);
  std::vector<std::string> off;
  std::vector<std::string> nearest;
  double slowest_Hz = std::numeric_limits<double>::infinity();
  const auto judge = [&](const std::vector<ident::Tone>& tones) {
    if (repeats && repeats_within(experiment, tones)) return;
    for (const ident::Tone& tone : tones) {
      const double cycles = tone.frequency_Hz * period_s;
      if (std::abs(cycles - std::round(cycles)) <= kCycleTolerance * std::max(1.0, cycles)) continue;
      slowest_Hz = std::min(slowest_Hz, tone.frequency_Hz);
      off.push_back(fmt::format("{:g}", tone.frequency_Hz));
      nearest.push_back(fmt::format("{:.4g}", std::max(1.0, std::round(cycles)) / period_s));
    }
  };
  const Played* played = experiment.played();
  if (played == nullptr) return std::nullopt;
  std::visit(
      [&](const auto& kind) {
        if constexpr (requires { kind.tones; }) judge(kind.tones);
      },
      played->excitation.kind);
  if (off.empty()) return std::nullopt;
  const bool is_one = off.size() == 1;
  const std::string part =
      fmt::format("{:g} s, {}", period_s, repeats ? "a repetition" : "half of what is used of the record");
  // Of tones slower than that the nearest ones would all be its own.
  const std::string instead =
      slowest_Hz * period_s < 1.0
          ? fmt::format("{:g} Hz alone needs duration_s = {:.4g} or more", slowest_Hz,
                        repeats ? 1.0 / slowest_Hz : experiment.fit.discard_s + 2.0 / slowest_Hz)
          : fmt::format("multiples of {:.4g} Hz do: {} Hz {} nearest", 1.0 / period_s, fmt::join(nearest, ", "),
                        is_one ? "is" : "are");
  return fmt::format(
      "excitation: {} Hz {} no whole number of periods in {}; {}. The measured frequency response leaves {} out",
      fmt::join(off, ", "), is_one ? "has" : "have", part, instead, is_one ? "this tone" : "these tones");
}

}  // namespace eha::config
