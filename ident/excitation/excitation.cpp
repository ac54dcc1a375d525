// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/excitation/excitation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "ident/excitation/harmonics.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha::ident {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr int kFewestLevels = 3;

void expect(bool holds, const char* key, const char* expected) {
  if (!holds) throw ConfigError(fmt::format("excitation.{}: expected {}", key, expected));
}

bool has_amplitude(ExcitationKind kind) { return kind != ExcitationKind::multisine && kind != ExcitationKind::sine; }

bool has_band(ExcitationKind kind) {
  return kind == ExcitationKind::odd_random_multisine || kind == ExcitationKind::gaussian ||
         kind == ExcitationKind::chirp;
}

void check_options(const ExcitationOptions& options, double step_s, std::size_t samples) {
  if (!(step_s > 0.0) || !std::isfinite(step_s)) throw ConfigError("excitation: expected a tick above 0 s");
  if (samples == 0) throw ConfigError("excitation: expected at least one sample");
  expect(std::isfinite(options.offset_V), "offset_V", "a finite voltage");
  if (has_amplitude(options.kind)) {
    expect(std::isfinite(options.amplitude_V), "amplitude_V", "a finite voltage");
  } else {
    expect(!options.tones.empty(), "tones", "at least one tone");
    expect(options.kind == ExcitationKind::multisine || options.tones.size() == 1, "tones", "one tone for a sine");
    for (const Tone& tone : options.tones) {
      expect(std::isfinite(tone.frequency_Hz) && tone.frequency_Hz > 0.0, "tones", "finite frequencies above 0 Hz");
      expect(std::isfinite(tone.amplitude_V) && std::isfinite(tone.phase_rad), "tones", "finite amplitudes and phases");
    }
  }
  if (has_band(options.kind)) {
    const bool rises = options.frequency_min_Hz >= 0.0 && options.frequency_min_Hz < options.frequency_max_Hz;
    expect(rises && std::isfinite(options.frequency_max_Hz), "frequency_max_Hz",
           "a band from 0 Hz or above to a higher frequency");
  }
  if (options.kind == ExcitationKind::prms || options.kind == ExcitationKind::step) {
    expect(std::isfinite(options.hold_s) && options.hold_s > 0.0, "hold_s", "a time above 0 s");
  }
  if (options.kind == ExcitationKind::prms) expect(options.levels >= kFewestLevels, "levels", "at least 3");
}

Eigen::VectorXd tones(const std::vector<Tone>& list, const Eigen::VectorXd& time_s) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(time_s.size());
  for (const Tone& tone : list) {
    for (Eigen::Index k = 0; k < sum.size(); ++k) {
      sum(k) += tone.amplitude_V * std::cos(kTwoPi * tone.frequency_Hz * time_s(k) + tone.phase_rad);
    }
  }
  return sum;
}

Eigen::VectorXd chirp(const ExcitationOptions& options, const Eigen::VectorXd& time_s, double length_s) {
  const double rate = (options.frequency_max_Hz - options.frequency_min_Hz) / (2.0 * length_s);
  return time_s.unaryExpr(
      [&](double t) { return options.amplitude_V * std::sin(kTwoPi * (options.frequency_min_Hz + rate * t) * t); });
}

Eigen::VectorXd multilevel(const ExcitationOptions& options, const Eigen::VectorXd& time_s, double step_s) {
  PortableDraw draw(options.seed);
  const auto hold = std::max<Eigen::Index>(1, std::llround(options.hold_s / step_s));
  const double spacing = 2.0 * options.amplitude_V / (options.levels - 1);
  Eigen::VectorXd table(time_s.size());
  double level = 0.0;
  for (Eigen::Index k = 0; k < table.size(); ++k) {
    if (k % hold == 0) {
      level =
          -options.amplitude_V + spacing * static_cast<double>(draw.below(static_cast<std::uint64_t>(options.levels)));
    }
    table(k) = level;
  }
  return table;
}

Eigen::VectorXd step(const ExcitationOptions& options, const Eigen::VectorXd& time_s, double step_s) {
  // The tick nearest to hold_s steps, whatever the rounding of k step_s.
  return time_s.unaryExpr([&](double t) { return t < options.hold_s - 0.5 * step_s ? 0.0 : options.amplitude_V; });
}

Eigen::VectorXd scaled_to(double peak, Eigen::VectorXd table) {
  const double present = table.cwiseAbs().maxCoeff();
  if (present > 0.0) table *= peak / present;
  return table;
}

Eigen::VectorXd table_without_offset(const ExcitationOptions& options, double step_s, std::size_t samples) {
  const auto count = static_cast<Eigen::Index>(samples);
  const Eigen::VectorXd time_s =
      Eigen::VectorXd::NullaryExpr(count, [&](Eigen::Index k) { return static_cast<double>(k) * step_s; });
  switch (options.kind) {
    case ExcitationKind::multisine:
    case ExcitationKind::sine:
      return tones(options.tones, time_s);
    case ExcitationKind::odd_random_multisine:
    case ExcitationKind::gaussian:
      return scaled_to(options.amplitude_V, sum_of(draw_harmonics(options, step_s, samples), samples));
    case ExcitationKind::prms:
      return multilevel(options, time_s, step_s);
    case ExcitationKind::chirp:
      return chirp(options, time_s, static_cast<double>(count) * step_s);
    case ExcitationKind::step:
      return step(options, time_s, step_s);
  }
  throw ConfigError("excitation.kind: expected one of the known kinds");
}

}  // namespace

Eigen::VectorXd excitation(const ExcitationOptions& options, double step_s, std::size_t samples) {
  check_options(options, step_s, samples);
  return table_without_offset(options, step_s, samples).array() + options.offset_V;
}

double crest_factor(const Eigen::Ref<const Eigen::VectorXd>& signal) {
  if (signal.size() == 0) throw DataError("crest_factor: expected at least one sample");
  const Eigen::ArrayXd centred = signal.array() - signal.mean();
  const double peak = centred.abs().maxCoeff();
  if (!(peak > 1e-14 * signal.cwiseAbs().maxCoeff())) throw DataError("crest_factor: the signal is constant");
  return peak / std::sqrt(centred.square().mean());
}

std::vector<double> excited_lines(const ExcitationOptions& options, double step_s, std::size_t samples) {
  check_options(options, step_s, samples);
  std::vector<double> lines_Hz;
  if (options.kind == ExcitationKind::odd_random_multisine || options.kind == ExcitationKind::gaussian) {
    const double period_s = static_cast<double>(samples) * step_s;
    for (const Harmonic& line : draw_harmonics(options, step_s, samples)) {
      lines_Hz.push_back(static_cast<double>(line.harmonic) / period_s);
    }
  } else if (!has_amplitude(options.kind)) {
    for (const Tone& tone : options.tones) lines_Hz.push_back(tone.frequency_Hz);
    std::sort(lines_Hz.begin(), lines_Hz.end());
  }
  return lines_Hz;
}

}  // namespace eha::ident
