// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/flat_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>
#include <vector>

#include "config/start_section.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "core/toml_text.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/design_command.hpp"
#include "daemon/eha/excitation_room.hpp"
#include "daemon/eha/next_command.hpp"
#include "daemon/eha/odd_random_design.hpp"
#include "daemon/eha/rig_source.hpp"
#include "ident/design/low_peak_phases.hpp"
#include "ident/excitation/tone.hpp"

namespace eha::cli {
namespace {

constexpr int kPeriods = 3;            ///< without repetitions; the first is discarded
constexpr double kDiscardShare = 0.2;  ///< of the first repetition

/// Returns harmonics of 1 / period, spread evenly over the logarithm of the band, each once.
std::vector<std::size_t> spread_harmonics(double low_Hz, double high_Hz, double period_s, int tones) {
  const double lowest = std::max(1.0, std::ceil(low_Hz * period_s - 1e-9));
  const double highest = std::floor(high_Hz * period_s + 1e-9);
  if (!(lowest < highest)) {
    throw UsageError(fmt::format("--band: expected a band that holds two multiples of 1/{:g} s, got {:g}:{:g} Hz",
                                 period_s, low_Hz, high_Hz));
  }
  std::vector<std::size_t> harmonics;
  for (int i = 0; i < tones; ++i) {
    const double share = tones == 1 ? 0.0 : static_cast<double>(i) / (tones - 1);
    harmonics.push_back(static_cast<std::size_t>(std::llround(lowest * std::pow(highest / lowest, share))));
  }
  // Low tones may coincide in one harmonic; the next free ones replace them.
  for (std::size_t i = 1; i < harmonics.size(); ++i) harmonics[i] = std::max(harmonics[i], harmonics[i - 1] + 1);
  while (!harmonics.empty() && static_cast<double>(harmonics.back()) > highest) harmonics.pop_back();
  return harmonics;
}

/// A signal bounded by one of the rig's limits: its amplitudes for tones of 1 V, and its greatest peak.
struct Bounded {
  const char* name;
  const char* unit;
  Eigen::VectorXcd amplitudes;
  double limit;
  double peak = 0.0;  ///< of tones of 1 V
};

std::array<Bounded, 3> bounded_signals(const std::vector<std::size_t>& harmonics, double period_s,
                                       const ExcitationRoom& room) {
  const auto count = static_cast<Eigen::Index>(harmonics.size());
  Eigen::VectorXcd volts = Eigen::VectorXcd::Ones(count);
  Eigen::VectorXcd slew(count);
  Eigen::VectorXcd travel(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::complex<double> s(
        0.0, ident::kTwoPi * static_cast<double>(harmonics[static_cast<std::size_t>(k)]) / period_s);
    slew[k] = s;
    travel[k] = room.gain_in_per_V_s / s;
  }
  return {Bounded{"voltage", "V", volts, room.peak_V}, Bounded{"slew", "V/s", slew, room.slew_V_per_s},
          Bounded{"travel", "in", travel, room.travel_in}};
}

/// Returns the signals that come near their limits, whose peaks must be kept low.
std::vector<Eigen::VectorXcd> crowded(const std::array<Bounded, 3>& signals) {
  constexpr double kShareOfGreatest = 0.5;
  double greatest = 0.0;
  for (const Bounded& signal : signals) greatest = std::max(greatest, signal.amplitudes.norm() / signal.limit);
  std::vector<Eigen::VectorXcd> near;
  for (const Bounded& signal : signals) {
    if (signal.amplitudes.norm() / signal.limit >= kShareOfGreatest * greatest) near.push_back(signal.amplitudes);
  }
  return near;
}

std::string band_experiment_text(const DesignCommand& command, const config::RigConfig& rig,
                                 const std::vector<std::size_t>& harmonics, const Eigen::VectorXd& phase_rad,
                                 double amplitude_V, double period_s, const std::string& remark) {
  std::string text = fmt::format(
      "# Made by `eha design --band {:g}:{:g} --tones {} --period {:g}` for \"{}\".\n# {}\nschema = 1\nname = "
      "\"band\"\n"
      "duration_s = {:.3f}\n{}\n{}\n\n[hold]\n\n[excitation]\nkind = \"multisine\"\n"
      "offset_V = {:.3f}\ntones = [\n",
      command.band->lowest_Hz, command.band->highest_Hz, command.tones, period_s, toml_comment(rig.name), remark,
      command.repetitions ? period_s : kPeriods * period_s,
      command.repetitions ? fmt::format("repetitions = {}\n", *command.repetitions) : "", config::start_at_middle(rig),
      rig.limits.following->null_V);
  for (std::size_t k = 0; k < harmonics.size(); ++k) {
    text +=
        fmt::format("  {{ frequency_Hz = {:.6f}, amplitude_V = {:.4f}, phase_rad = {:.4f} }},\n",
                    static_cast<double>(harmonics[k]) / period_s, amplitude_V, phase_rad[static_cast<Eigen::Index>(k)]);
  }
  const int decimation = compared_ticks(static_cast<double>(harmonics.back()) / period_s, rig.realtime.sample_period_s);
  text += fmt::format("]\n\n[record]\ndiscard_s = {:.3f}\ndecimation = {}\n",
                      command.repetitions ? kDiscardShare * period_s : period_s, decimation);
  if (command.precision_percent) {
    text += fmt::format("\n[precision]  # ends the run after the repetition that reaches it\ngain_percent = {:g}\n",
                        *command.precision_percent);
  }
  return text;
}

}  // namespace

ExitCode design_flat(const DesignCommand& command, Console& console) {
  if (command.realisations) return design_odd_random(command, console);
  const config::RigConfig rig = load_rig_or_default(command.rig_file);
  const ExcitationRoom room = excitation_room(rig);
  const auto [low_Hz, high_Hz] = *command.band;
  const double period_s = command.period_s;
  const std::vector<std::size_t> harmonics = spread_harmonics(low_Hz, high_Hz, period_s, command.tones);
  std::array<Bounded, 3> signals = bounded_signals(harmonics, period_s, room);
  const Eigen::VectorXd phase_rad = ident::low_peak_phases(harmonics, crowded(signals));
  const Bounded* binding = nullptr;
  double amplitude_V = 0.0;
  for (Bounded& signal : signals) {
    signal.peak = ident::crest_factor_of(harmonics, signal.amplitudes, phase_rad) * signal.amplitudes.norm() /
                  std::numbers::sqrt2;
    if (binding == nullptr || signal.limit / signal.peak < amplitude_V) {
      binding = &signal;
      amplitude_V = signal.limit / signal.peak;
    }
  }
  amplitude_V = std::floor(amplitude_V * 1e4) / 1e4;
  const double rms_V = amplitude_V * std::sqrt(0.5 * static_cast<double>(harmonics.size()));
  const DisplayUnit unit = console.unit(rig.units);
  const std::string remark = fmt::format(
      "{} tones of {:.3g} V, peak {:.3g} V, +-{:.3g} {}; the {} limit binds", harmonics.size(), amplitude_V,
      amplitude_V * signals[0].peak, unit.factor("in") * amplitude_V * signals[2].peak, unit.of("in"), binding->name);
  const std::filesystem::path file = command.output.value_or("band.toml");
  os::write_file_atomically(file,
                            band_experiment_text(command, rig, harmonics, phase_rad, amplitude_V, period_s, remark));
  nlohmann::ordered_json document{{"schema", "eha-design/1"},   {"file", file.string()}, {"tones", harmonics.size()},
                                  {"amplitude_V", amplitude_V}, {"rms_V", rms_V},        {"binding", binding->name}};
  console.print(remark);
  for (const Bounded& signal : signals) {
    const double crest = signal.peak * std::numbers::sqrt2 / signal.amplitudes.norm();
    document["crest_factor"][signal.name] = crest;
    const double factor = unit.factor(signal.unit);
    console.print(fmt::format("{:<8} peak {:.3g} of {:.3g} {}, crest factor {:.3f}", signal.name,
                              factor * amplitude_V * signal.peak, factor * signal.limit, unit.of(signal.unit), crest));
  }
  warn_of_dead_band(rms_V, room, console);
  console.print_json(document);
  console.print(written_for(file, command, rig));
  console.next_step(suggest::run(access_of_design(command, rig), {file.string()}));
  return ExitCode::ok;
}

}  // namespace eha::cli
