// SPDX-License-Identifier: GPL-3.0-or-later
#include "config/experiment_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "config/characterisation.hpp"
#include "config/measured_check.hpp"
#include "config/needs_following.hpp"
#include "config/prepared_experiment.hpp"
#include "config/valve_estimate.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "core/millimetre_key.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/excitation.hpp"

namespace eha::config {
namespace {

/// Longest table, 2.8 hours at 1 kHz: it is held in memory.
constexpr double kMostSamples = 1e7;
/// Tolerance of a duration against a whole number of ticks, for the rounding of decimals [ticks].
constexpr double kTickTolerance = 1e-6;
/// Relative tolerance of a peak or slope against its limit, for the rounding of the table.
constexpr double kRounding = 1e-9;

/// Bounds of a played controller, as shares of the velocity limit and of the travel.
constexpr double kTrackedSpeedShare = 0.5;
constexpr double kTrackedErrorShare = 0.05;
/// Greatest deviation of the controller's valve from [following]: null and dead band, and each gain as a ratio.
constexpr double kTrackedValve_V = 0.1;
constexpr double kTrackedGainRatio = 1.5;

/// Rounds to three digits, never up.
double rounded_down(double factor) {
  const double unit = std::pow(10.0, std::floor(std::log10(factor)) - 2.0);
  return std::floor(factor / unit) * unit;
}

class ConflictSearch {
 public:
  ConflictSearch(const ExperimentConfig& experiment, const PositionMap& positions, const RigConfig& rig,
                 IssueList& issues)
      : experiment_(experiment), positions_(positions), rig_(rig), issues_(issues) {}

  Eigen::VectorXd run() {
    // Every way to move a rod prepares its experiment here.
    if (needs_following(rig_) && !experiment_.characterises()) {
      issues_.add_text(position_of(positions_, ""), rig_.file_name, kNeedsFollowing);
      return {};
    }
    if (const Played* played = experiment_.played()) check_frequencies(*played);
    if (!issues_.clean("duration_s") || !issues_.clean("track")) return {};
    if (!check_samples()) return {};
    return std::visit([&](const auto& kind) { return table_of(kind); }, experiment_.kind);
  }

 private:
  // Computes the table of volts of each kind, after the checks of its keys.
  Eigen::VectorXd table_of(const Played& played) {
    check_decimation();
    if (played.start) check_place("start.displacement_in", *played.start);
    if (played.hold) check_hold(*played.hold);
    return issues_.clean("excitation") ? check_table(played.excitation) : Eigen::VectorXd();
  }
  Eigen::VectorXd table_of(const Placing& placing) {
    check_place("place.displacement_in", placing.place);
    if (placing.brings_back) check_way_back();
    return no_volts();
  }
  Eigen::VectorXd table_of(const SheetRun& sheet) {
    if (sheet.start) check_place("start.displacement_in", *sheet.start);
    return characterisation_plan(rig_).table_V;
  }
  Eigen::VectorXd table_of(const Tracking& tracking) {
    if (tracking.start) check_place("start.displacement_in", *tracking.start);
    check_track(tracking.track.controller);
    return no_volts();
  }

  [[nodiscard]] Eigen::VectorXd no_volts() const {
    return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(samples_per_repetition(experiment_, rig_)));
  }

  [[nodiscard]] double tick_s() const { return rig_.realtime.sample_period_s; }

  void add(const std::string& key, const std::string& expected, const std::string& got) {
    issues_.add(position_of(positions_, key), key, expected, got);
  }

  [[nodiscard]] bool check_samples() {
    const double samples = experiment_.duration_s / tick_s();
    if (samples > kMostSamples) {
      add("duration_s", fmt::format("at most {} ticks of {} s", kMostSamples, tick_s()),
          fmt::format("{:.0f}", samples));
      return false;
    }
    if (std::round(samples) < 1.0 || std::abs(samples - std::round(samples)) > kTickTolerance) {
      add("duration_s", fmt::format("a whole number of ticks of {} s", tick_s()),
          fmt::format("{} s, {:.6g} ticks", experiment_.duration_s, samples));
      return false;
    }
    return true;
  }

  void check_decimation() {
    if (!issues_.clean("record.decimation")) return;
    const std::size_t samples = samples_per_repetition(experiment_, rig_);
    const auto decimation = static_cast<std::size_t>(experiment_.fit.decimation);
    if (samples % decimation != 0) {
      add("record.decimation", fmt::format("a divisor of the {} samples", samples), fmt::format("{}", decimation));
    }
  }

  void check_place(const std::string& key, const Place& place) {
    if (!issues_.clean(key)) return;
    const double margin_in = placing_margin_in(rig_);
    const double lowest_in = rig_.limits.travel_min_in + margin_in;
    const double highest_in = rig_.limits.travel_max_in - margin_in;
    if (place.displacement_in >= lowest_in && place.displacement_in <= highest_in) return;
    const auto in_mm = millimetre_key(key);
    const bool is_in_mm = in_mm && positions_.contains(in_mm->name);
    const DisplayUnit unit(is_in_mm ? "mm" : "in");  // of the key
    const double factor = unit.factor("in");
    issues_.add(position_of(positions_, key), is_in_mm ? in_mm->name : key,
                fmt::format("{0:.4g} to {1:.4g} {4}, the travel limits of {2} less {3:.3g} {4}", factor * lowest_in,
                            factor * highest_in, rig_.file_name, factor * margin_in, unit.of("in")),
                fmt::format("{:.4g} {}", factor * place.displacement_in, unit.of("in")));
  }

  /// Beyond a travel limit only the sensor shows the position: its plausibility must be checked.
  void check_way_back() {
    if (!hal::moves_machine(rig_.backend)) return;
    const auto refuse = [&](const std::string& expected, const std::string& got) {
      add("place.way_back",
          fmt::format("{} in {}; else move the rod by hand with the hydraulics off", expected, rig_.file_name), got);
    };
    const auto& sensor = rig_.limits.sensor;
    if (!sensor || !sensor->open_circuit_V) {
      refuse("[sensor] with open_circuit_V, so that an open wire is no rod beyond a limit,", "none");
      return;
    }
    if (*sensor->open_circuit_V >= sensor->valid_min_V && *sensor->open_circuit_V <= sensor->valid_max_V) {
      refuse(fmt::format("an open_circuit_V outside the valid band of the sensor, {:g} to {:g} V,", sensor->valid_min_V,
                         sensor->valid_max_V),
             fmt::format("{:g} V", *sensor->open_circuit_V));
    }
  }

  void check_hold(const Hold& hold) {
    if (!rig_.limits.following) {
      add("hold", fmt::format("[following] in {}, which predicts where the rod should be", rig_.file_name), "none");
      return;
    }
    const std::optional<double>& gain = hold.gain_V_per_in;
    const double most = hold_gains(rig_).most;
    if (gain && *gain > most) {
      add("hold.gain_V_per_in", fmt::format("at most {:.3g} V/in for the gains of {}", most, rig_.file_name),
          fmt::format("{:g}", *gain));
    }
  }

  /// A controller is played only on the rig that it was made for.
  void check_track(const ControllerConfig& controller) {
    const ident::AxisSettings& s = controller.settings;
    const RigLimits& limits = rig_.limits;
    const DisplayUnit unit(rig_.units);
    const double factor = unit.factor("in");
    const std::string in = unit.of("in");
    const auto refuse = [&](const std::string& expected, const std::string& got) {
      add("track.controller", expected + "; make it anew: `eha tune`", got);
    };
    check_tracked_valve(s.inverse);
    if (controller.provenance.rig != rig_.name) {
      add("track.controller",
          fmt::format(
              "a controller for {}, the rig of {}; name the rig file of the controller's rig with --rig, or make "
              "another controller of a run of this rig: `eha run EXPERIMENT`, then `eha tune NEWRUN`",
              rig_.name, rig_.file_name),
          fmt::format("one for {}", controller.provenance.rig));
      return;
    }
    if (std::abs(s.tick_s / tick_s() - 1.0) > kTickTolerance) {
      add("track.controller",
          fmt::format(
              "a controller for the tick of {} s; play it on a copy of the rig file with sample_period_s = {}, or make "
              "another: `eha tune`, with --tick {}",
              tick_s(), s.tick_s, tick_s()),
          fmt::format("{} s", s.tick_s));
    }
    if (s.reference.lowest < limits.travel_min_in || s.reference.highest > limits.travel_max_in) {
      refuse(fmt::format("travel within {:g} to {:g} {}", factor * limits.travel_min_in, factor * limits.travel_max_in,
                         in),
             fmt::format("{:g} to {:g} {}", factor * s.reference.lowest, factor * s.reference.highest, in));
    }
    if (s.command_min < limits.command_min_V || s.command_max > limits.command_max_V) {
      refuse(fmt::format("commands within {:g} to {:g} V", limits.command_min_V, limits.command_max_V),
             fmt::format("{:g} to {:g} V", s.command_min, s.command_max));
    }
    const double most_V = closed_loop_most_V(limits) * (1.0 + kRounding);
    if (s.command_max - s.inverse.null > most_V || s.inverse.null - s.command_min > most_V) {
      refuse(fmt::format("commands within {:g} V of the null, as limits.closed_loop_max_V allows", most_V),
             fmt::format("{:g} to {:g} V about {:g} V", s.command_min, s.command_max, s.inverse.null));
    }
    if (s.slew_per_s > limits.slew_V_per_s * (1.0 + kRounding)) {
      refuse(fmt::format("a slew of at most {:g} V/s", limits.slew_V_per_s), fmt::format("{:g} V/s", s.slew_per_s));
    }
    if (s.reference.velocity > kTrackedSpeedShare * limits.velocity_limit_in_per_s) {
      refuse(fmt::format("references of at most {:g} {}/s, half the velocity limit",
                         factor * kTrackedSpeedShare * limits.velocity_limit_in_per_s, in),
             fmt::format("{:g} {}/s", factor * s.reference.velocity, in));
    }
    const double most_error_in = kTrackedErrorShare * (limits.travel_max_in - limits.travel_min_in);
    if (controller.fault.following_error_in > most_error_in) {
      refuse(fmt::format("a fault beyond an error of at most {:.3f} {}, a twentieth of the travel",
                         factor * most_error_in, in),
             fmt::format("{:g} {}", factor * controller.fault.following_error_in, in));
    }
  }

  /// Checks the controller's valve against that of the rig file, so that no single wrong number drives the rod.
  void check_tracked_valve(const ident::InverseMap& inverse) {
    if (!rig_.limits.following) return;
    const ValveEstimate valve = valve_estimate(*rig_.limits.following);
    const DisplayUnit unit(rig_.units);
    std::vector<std::string> of_valve;
    std::vector<std::string> of_controller;
    const auto compare_volts = [&](const char* name, double made_for, double known) {
      if (std::abs(made_for - known) <= kTrackedValve_V) return;
      of_valve.push_back(fmt::format("a {} of {:.3g} V", name, known));
      of_controller.push_back(fmt::format("{:.3g} V", made_for));
    };
    const auto compare_gains = [&](const char* way, double made_for, double known) {
      if (made_for < kTrackedGainRatio * known && known < kTrackedGainRatio * made_for) return;
      const double factor = unit.factor("in");
      of_valve.push_back(fmt::format("a gain {} of {:.3g} {}/(V s)", way, factor * known, unit.of("in")));
      of_controller.push_back(fmt::format("{:.3g} {}/(V s)", factor * made_for, unit.of("in")));
    };
    compare_volts("null", inverse.null, valve.null_V);
    compare_volts("half dead band", inverse.dead_band, valve.dead_band_V);
    compare_gains("extending", inverse.gain_positive, valve.gain_positive_in_per_V_s);
    compare_gains("retracting", inverse.gain_negative, valve.gain_negative_in_per_V_s);
    if (of_valve.empty()) return;
    const char* remedy =
        is_as_measured(rig_)
            ? "this valve was measured, so the controller's model is of another one: play its experiment again (`eha "
              "run EXPERIMENT`), then `eha tune NEWRUN`"
            : "measure it with `eha characterise`; if it is right, play the experiment of the controller's model again "
              "(`eha run EXPERIMENT`), then `eha tune NEWRUN`";
    add("track.controller",
        fmt::format("a controller for the valve of [following] in {}, which has {}", rig_.file_name,
                    fmt::join(of_valve, " and ")),
        fmt::format("one for {}; {}", fmt::join(of_controller, " and "), remedy));
  }

  void check_frequency(const std::string& key, double frequency_Hz) {
    if (!issues_.clean(key) || !positions_.contains(key)) return;
    const double tick_nyquist_Hz = 0.5 / tick_s();
    if (frequency_Hz >= tick_nyquist_Hz) {
      add(key, fmt::format("less than the Nyquist frequency of the tick, {:.6g} Hz", tick_nyquist_Hz),
          fmt::format("{}", frequency_Hz));
      return;
    }
    if (!issues_.clean("record.decimation")) return;
    const double nyquist_Hz = tick_nyquist_Hz / experiment_.fit.decimation;
    if (frequency_Hz >= nyquist_Hz) {
      add(key, fmt::format("less than the Nyquist frequency of the decimated record, {:.6g} Hz", nyquist_Hz),
          fmt::format("{}", frequency_Hz));
    }
  }

  void check_frequencies(const Played& played) {
    for (const ident::KeyFrequency& key : ident::key_frequencies_of(played.excitation)) {
      check_frequency(fmt::format("excitation.{}", key.key), key.frequency_Hz);
    }
  }

  Eigen::VectorXd check_table(const ident::Excitation& excitation) {
    for (const OptionIssue& issue : ident::timing_issues_of(excitation, tick_s(), experiment_.duration_s)) {
      const std::string key = fmt::format("excitation.{}", issue.key);
      issues_.add_text(position_of(positions_, key), key, issue.message);
    }
    if (!issues_.clean("excitation")) return {};
    Eigen::VectorXd table;
    try {
      table = ident::excitation(excitation, tick_s(), samples_per_repetition(experiment_, rig_));
    } catch (const ConfigError& error) {
      add("excitation", "a signal that can be played", error.what());
      return {};
    }
    check_peak(table);
    check_slew(table, excitation.offset_V,
               ident::shortest_level_s(excitation, experiment_.duration_s).value_or(tick_s()));
    return table;
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
    if (maximum > rig_.limits.command_max_V + room) add("excitation", expected, at(maximum, highest));
    if (minimum < rig_.limits.command_min_V - room) add("excitation", expected, at(minimum, lowest));
  }

  /// The share of the amplitudes that the command limits let pass. @param offset_V  which keeps its value
  [[nodiscard]] double share_within_range(const Eigen::VectorXd& table, double offset_V) const {
    const double above = (rig_.limits.command_max_V - offset_V) / std::max(0.0, table.maxCoeff() - offset_V);
    const double below = (offset_V - rig_.limits.command_min_V) / std::max(0.0, offset_V - table.minCoeff());
    return std::max(0.0, std::min(above, below));
  }

  /// A jump is played as a ramp at the slew limit; the ramp must end before the next jump.
  /// @param time_s  the shortest time between jumps, at least a tick
  void check_slew(const Eigen::VectorXd& table, double offset_V, double time_s) {
    if (table.size() < 2) return;
    Eigen::Index k = 0;
    const double change_V = (table.tail(table.size() - 1) - table.head(table.size() - 1)).cwiseAbs().maxCoeff(&k);
    const double limit = rig_.limits.slew_V_per_s;
    if (change_V <= limit * time_s * (1.0 + kRounding)) return;
    add("excitation", fmt::format("changes within the limit of {}, {} V/s", rig_.file_name, limit),
        fmt::format(
            "{:.4g} V within {:.6g} s at {:.6g} s (peak {:.3g} V, RMS {:.3g} V); all amplitudes times {:.3g} pass",
            change_V, time_s, static_cast<double>(k + 1) * tick_s(), table.cwiseAbs().maxCoeff(),
            std::sqrt(table.squaredNorm() / static_cast<double>(table.size())),
            rounded_down(std::min(limit * time_s / change_V, share_within_range(table, offset_V)))));
  }

  const ExperimentConfig& experiment_;
  const PositionMap& positions_;
  const RigConfig& rig_;
  IssueList& issues_;
};

}  // namespace

Eigen::VectorXd check_table(const ExperimentConfig& experiment, const PositionMap& positions, const RigConfig& rig,
                            IssueList& issues) {
  return ConflictSearch(experiment, positions, rig, issues).run();
}

PreparedExperiment prepare(ExperimentConfig experiment, const RigConfig& rig) {
  IssueList issues(experiment.file_name);
  Eigen::VectorXd table_V = check_table(experiment, experiment.positions, rig, issues);
  issues.throw_if_any();
  PreparedExperiment prepared{std::move(experiment), std::move(table_V), {}};
  const Played* played = prepared.config.played();
  if (played != nullptr && played->hold)
    prepared.predicted_in = predicted_displacement(prepared.config, rig, prepared.table_V);
  return prepared;
}

std::size_t samples_per_repetition(const ExperimentConfig& experiment, const RigConfig& rig) {
  return static_cast<std::size_t>(std::llround(experiment.duration_s / rig.realtime.sample_period_s));
}

}  // namespace eha::config
