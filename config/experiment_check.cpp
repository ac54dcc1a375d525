// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/experiment_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::config {
namespace {

/// Longest table, 2.8 hours at 1 kHz: it is held in memory.
constexpr double kMostSamples = 1e7;
/// A duration may miss a whole number of ticks by the rounding of decimals, in ticks.
constexpr double kTickTolerance = 1e-6;
/// A peak or slope may exceed its limit by the rounding of the table, relative.
constexpr double kRounding = 1e-9;

using ident::ExcitationKind;

class ConflictSearch {
 public:
  ConflictSearch(const ExperimentConfig& experiment, const PositionMap& positions, const RigConfig& rig,
                 FaultList& faults)
      : experiment_(experiment), positions_(positions), rig_(rig), faults_(faults) {}

  void run() {
    check_frequencies();
    if (!faults_.clean("duration_s")) return;
    if (!check_samples()) return;
    check_decimation();
    if (faults_.clean("excitation")) check_table();
  }

 private:
  [[nodiscard]] double tick_s() const { return rig_.realtime.sample_period_s; }

  void fault(const std::string& key, const std::string& expected, const std::string& got) {
    faults_.add(position_of(positions_, key), key, expected, got);
  }

  [[nodiscard]] bool check_samples() {
    const double samples = experiment_.duration_s / tick_s();
    if (samples > kMostSamples) {
      fault("duration_s", fmt::format("at most {} ticks of {} s", kMostSamples, tick_s()),
            fmt::format("{:.0f}", samples));
      return false;
    }
    if (std::round(samples) < 1.0 || std::abs(samples - std::round(samples)) > kTickTolerance) {
      fault("duration_s", fmt::format("a whole number of ticks of {} s", tick_s()),
            fmt::format("{} s, {:.6g} ticks", experiment_.duration_s, samples));
      return false;
    }
    return true;
  }

  void check_decimation() {
    if (!faults_.clean("record.decimation")) return;
    const std::size_t samples = samples_per_repetition(experiment_, rig_);
    const auto decimation = static_cast<std::size_t>(experiment_.fit.decimation);
    if (samples % decimation != 0) {
      fault("record.decimation", fmt::format("a divisor of the {} samples", samples), fmt::format("{}", decimation));
    }
  }

  void check_frequency(const std::string& key, double frequency_Hz) {
    if (!faults_.clean(key) || !positions_.contains(key)) return;
    const double tick_nyquist_Hz = 0.5 / tick_s();
    if (frequency_Hz >= tick_nyquist_Hz) {
      fault(key, fmt::format("less than the Nyquist frequency of the tick, {:.6g} Hz", tick_nyquist_Hz),
            fmt::format("{}", frequency_Hz));
      return;
    }
    if (!faults_.clean("record.decimation")) return;
    const double nyquist_Hz = tick_nyquist_Hz / experiment_.fit.decimation;
    if (frequency_Hz >= nyquist_Hz) {
      fault(key, fmt::format("less than the Nyquist frequency of the decimated record, {:.6g} Hz", nyquist_Hz),
            fmt::format("{}", frequency_Hz));
    }
  }

  void check_frequencies() {
    const auto& tones = experiment_.excitation.tones;
    for (std::size_t i = 0; i < tones.size(); ++i) {
      check_frequency(fmt::format("excitation.tones[{}].frequency_Hz", i), tones[i].frequency_Hz);
    }
    check_frequency("excitation.frequency_max_Hz", experiment_.excitation.frequency_max_Hz);
  }

  void check_table() {
    Eigen::VectorXd table;
    try {
      table = ident::excitation(experiment_.excitation, tick_s(), samples_per_repetition(experiment_, rig_));
    } catch (const ConfigError& error) {
      fault("excitation", "a signal that can be played", error.what());
      return;
    }
    check_peak(table);
    check_slew(table);
    check_hold();
  }

  void check_peak(const Eigen::VectorXd& table) {
    const double room = kRounding * std::max(std::abs(rig_.limits.command_min_V), std::abs(rig_.limits.command_max_V));
    Eigen::Index highest = 0;
    Eigen::Index lowest = 0;
    const double maximum = table.maxCoeff(&highest);
    const double minimum = table.minCoeff(&lowest);
    const std::string expected = fmt::format("voltages within the limits of {}, {}..{} V", rig_.file_name,
                                             rig_.limits.command_min_V, rig_.limits.command_max_V);
    const auto at = [&](double value, Eigen::Index k) {
      return fmt::format("{:.4g} V at {:.6g} s", value, static_cast<double>(k) * tick_s());
    };
    if (maximum > rig_.limits.command_max_V + room) fault("excitation", expected, at(maximum, highest));
    if (minimum < rig_.limits.command_min_V - room) fault("excitation", expected, at(minimum, lowest));
  }

  [[nodiscard]] bool jumps() const {
    return experiment_.excitation.kind == ExcitationKind::prms || experiment_.excitation.kind == ExcitationKind::step;
  }

  /// A jump is played as a ramp at the slew limit; it must get where it goes before the next one.
  void check_slew(const Eigen::VectorXd& table) {
    if (table.size() < 2) return;
    Eigen::Index k = 0;
    const double change_V = (table.tail(table.size() - 1) - table.head(table.size() - 1)).cwiseAbs().maxCoeff(&k);
    const double time_s = jumps() ? shortest_level_s() : tick_s();
    const double limit = rig_.limits.slew_V_per_s;
    if (change_V <= limit * time_s * (1.0 + kRounding)) return;
    fault("excitation", fmt::format("changes within the limit of {}, {} V/s", rig_.file_name, limit),
          fmt::format("{:.4g} V within {:.6g} s at {:.6g} s", change_V, time_s, static_cast<double>(k + 1) * tick_s()));
  }

  [[nodiscard]] double shortest_level_s() const {
    const double hold_s = experiment_.excitation.hold_s;
    return experiment_.excitation.kind == ExcitationKind::prms ? hold_s : experiment_.duration_s - hold_s;
  }

  void check_hold() {
    if (!jumps()) return;
    const double hold_s = experiment_.excitation.hold_s;
    if (hold_s < tick_s() || hold_s >= experiment_.duration_s) {
      fault("excitation.hold_s",
            fmt::format("a time from one tick, {} s, to less than duration_s = {}", tick_s(), experiment_.duration_s),
            fmt::format("{}", hold_s));
    }
  }

  const ExperimentConfig& experiment_;
  const PositionMap& positions_;
  const RigConfig& rig_;
  FaultList& faults_;
};

}  // namespace

void add_conflicts(const ExperimentConfig& experiment, const PositionMap& positions, const RigConfig& rig,
                   FaultList& faults) {
  ConflictSearch(experiment, positions, rig, faults).run();
}

void check_against(const ExperimentConfig& experiment, const RigConfig& rig) {
  FaultList faults(experiment.file_name);
  add_conflicts(experiment, experiment.positions, rig, faults);
  faults.throw_if_any();
}

std::size_t samples_per_repetition(const ExperimentConfig& experiment, const RigConfig& rig) {
  return static_cast<std::size_t>(std::llround(experiment.duration_s / rig.realtime.sample_period_s));
}

}  // namespace eha::config
