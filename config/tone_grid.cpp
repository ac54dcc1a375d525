// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/tone_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

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

std::vector<std::string> off_grid_tones(const ExperimentConfig& experiment) {
  const bool repeats = experiment.repetitions > 1;
  const double period_s = repeats ? experiment.duration_s : 0.5 * (experiment.duration_s - experiment.fit.discard_s);
  std::vector<std::string> sentences;
  const auto judge = [&](const std::vector<ident::Tone>& tones) {
    if (repeats && repeats_within(experiment, tones)) return;
    for (const ident::Tone& tone : tones) {
      const double cycles = tone.frequency_Hz * period_s;
      if (std::abs(cycles - std::round(cycles)) <= kCycleTolerance * std::max(1.0, cycles)) continue;
      sentences.push_back(
          fmt::format("excitation: {:g} Hz is no multiple of 1/{:g} s ({}): {:g} Hz is the nearest; the measured "
                      "frequency response leaves this tone out",
                      tone.frequency_Hz, period_s, repeats ? "a repetition" : "half of what is used of the record",
                      std::max(1.0, std::round(cycles)) / period_s));
    }
  };
  const Played* played = experiment.played();
  if (played == nullptr) return {};
  std::visit(
      [&](const auto& kind) {
        if constexpr (requires { kind.tones; }) judge(kind.tones);
      },
      played->excitation.kind);
  return sentences;
}

}  // namespace eha::config
