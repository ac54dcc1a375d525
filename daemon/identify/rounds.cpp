// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/rounds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "config/prepared_experiment.hpp"
#include "config/rig_config.hpp"
#include "config/valve_estimate.hpp"
#include "core/display_unit.hpp"
#include "core/error.hpp"
#include "daemon/identify/multisine_text.hpp"
#include "daemon/rehearsal/rehearsal.hpp"

namespace eha::identify {
namespace {

constexpr int kMostRepetitions = 16;
constexpr int kMostForLength = 200;  ///< where the record is too short to judge

/// Where the value of a top-level key begins, at the start of a line; npos without one.
std::size_t value_of(const std::string& top, const std::string& key) {
  for (std::size_t line = 0; line < top.size();) {
    std::size_t at = line + key.size();
    if (top.compare(line, key.size(), key) == 0) {
      at = top.find_first_not_of(" \t", at);
      if (at != std::string::npos && top[at] == '=') return std::min(top.find_first_not_of(" \t", at + 1), top.size());
    }
    line = top.find('\n', line);
    if (line != std::string::npos) ++line;
  }
  return std::string::npos;
}

/// Sets a top-level key in the text. @param after  the key after which a missing one is inserted
std::string with_number(std::string text, const std::string& key, int value, const std::string& after) {
  const std::string top = text.substr(0, text.find("\n["));
  if (const std::size_t at = value_of(top, key); at != std::string::npos) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789", at), text.size());
    return text.replace(at, end - at, std::to_string(value));
  }
  const std::size_t before = value_of(top, after);
  if (before == std::string::npos) return text;
  return text.insert(std::min(text.find('\n', before), text.size()), fmt::format("\n{} = {}", key, value));
}

/// The rig of a run; none for a file.
std::optional<config::RigConfig> rig_of(const Source& source) {
  if (source.rig_text.empty()) return std::nullopt;
  return config::parse_rig(source.rig_text, "the run's rig file");
}

config::PreparedExperiment prepared(const std::string& text, const config::RigConfig& rig) {
  return config::parse_prepared_experiment(text, std::string(kNextExperimentFile), rig);
}

/// Rehearses an experiment on a rig. @returns none where it cannot be rehearsed
std::optional<Rehearsal> rehearsed(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  return rehearse(experiment, rig, start_of(rig));
}

/// Twice as many, and enough for two whole ones behind the discarded time, which the measured frequency response needs.
int more_repetitions(const config::ExperimentConfig& experiment) {
  const double behind = std::ceil(2.0 + experiment.fit.discard_s / experiment.duration_s - 1e-9);
  return std::max(2 * experiment.repetitions, static_cast<int>(std::min(behind, 1e6)));
}

/// Enough for a record of which so much is used.
int repetitions_for(const config::ExperimentConfig& experiment, double used_s) {
  const double wanted = std::ceil((used_s + experiment.fit.discard_s) / experiment.duration_s - 1e-9);
  return static_cast<int>(std::clamp(wanted, 0.0, 1e6));
}

/// Whether the input stands still most of the time, as a step does.
bool moves_rarely(const config::PreparedExperiment& experiment) {
  constexpr int kFewMoves = 10;
  int moves = 0;
  bool was_moving = false;
  for (Eigen::Index k = 1; k < experiment.table_V.size(); ++k) {
    const bool is_moving = std::abs(experiment.table_V[k] - experiment.table_V[k - 1]) > 0.0;
    if (is_moving && !was_moving) ++moves;
    was_moving = is_moving;
  }
  return !was_moving && moves < kFewMoves;
}

/// Whether the input has so few tones that no length of it tells the structures of the ladder apart.
bool has_few_tones(const config::PreparedExperiment& experiment, double tick_s) {
  constexpr std::size_t kFewestTones = 3;
  if (experiment.config.played() == nullptr) return false;
  const auto lines = ident::excited_lines(experiment.config.played()->excitation, tick_s,
                                          static_cast<std::size_t>(experiment.table_V.size()));
  return !lines.empty() && lines.size() < kFewestTones;
}

bool passes(const std::optional<Rehearsal>& rehearsal) {
  return !rehearsal || rehearsal->chance_of_trip < kWarnedChanceOfTrip;
}

/// Replaces [excitation] of an experiment by three tones of whole periods in its duration.
/// @param share  of the amplitudes of the paper's tones
std::string with_tones(const config::ExperimentConfig& experiment, double offset_V, double share) {
  const std::array<ident::Tone, 3> paper{{{0.05, 1.9, 1.8}, {0.2, 1.6, 1.9}, {0.65, 1.5, 4.2}}};  // as paper.toml
  std::vector<ident::Tone> tones;
  double periods = 0.0;
  for (const ident::Tone& tone : paper) {
    periods = std::max(periods + 1.0, std::round(tone.frequency_Hz * experiment.duration_s));
    tones.push_back({periods / experiment.duration_s, share * tone.amplitude_V, tone.phase_rad});
  }
  const std::string table = multisine_table(offset_V, tones);
  const std::size_t begin = experiment.text.find("[excitation]");
  if (begin == std::string::npos) return {};
  const std::size_t end = experiment.text.find("\n[", begin);
  return experiment.text.substr(0, begin) + table + (end == std::string::npos ? "\n" : experiment.text.substr(end));
}

/// The experiment in two repetitions of so many whole seconds together, so that each half has whole periods.
config::ExperimentConfig in_two_pieces(config::ExperimentConfig experiment, double length_s) {
  experiment.duration_s = std::ceil(0.5 * length_s);
  experiment.text = with_number(experiment.text, "duration_s", static_cast<int>(experiment.duration_s), "name");
  experiment.text = with_number(experiment.text, "repetitions", 2, "duration_s");
  return experiment;
}

/// The greatest tones that the rehearsal lets pass; empty: none, or the rig cannot be rehearsed.
std::string text_with_tones(const config::ExperimentConfig& experiment, const config::RigConfig& rig) {
  if (!rig.limits.following) return {};
  for (const double share : {1.0, 0.7, 0.5, 0.35, 0.25}) {
    double offset_V = rig.limits.following->null_V;
    for (int attempt = 0; attempt < 2; ++attempt) {
      try {
        const std::string text = with_tones(experiment, offset_V, share);
        const auto rehearsal = rehearsed(prepared(text, rig), rig);
        if (!rehearsal) return {};
        if (attempt == 0 && rehearsal->still_offset_V) {
          offset_V = *rehearsal->still_offset_V;
          continue;
        }
        if (passes(rehearsal)) return text;
      } catch (const Error&) {  // beyond the command or slew limits
      }
      break;
    }
  }
  return {};
}

std::string reach_text(double reach_V, const config::RigConfig& rig) {
  return fmt::format("the volts went {:.2g} V from the valve's null, of which its dead band takes {:.2g} V", reach_V,
                     config::valve_estimate(*rig.limits.following).dead_band_V);
}

}  // namespace

std::string within_dead_band(const Source& source) {
  if (!source.experiment || source.experiment->text.empty()) return {};
  try {
    const std::optional<config::RigConfig> rig = rig_of(source);
    const auto reach_V = rig ? reach_within_dead_band(prepared(source.experiment->text, *rig), *rig) : std::nullopt;
    return reach_V ? reach_text(*reach_V, *rig) : std::string();
  } catch (const Error&) {  // plays nothing that can be prepared
    return {};
  }
}

namespace {

/// "the rod comes to 4.2 in, and the rig's limit is 4.2 in"; empty where it stays clear of both limits.
std::string near_travel_limit(const Source& source, const config::RigConfig& rig) {
  constexpr double kNearShare = 0.02;  // of the travel between the limits
  const config::RigLimits& limits = rig.limits;
  const DisplayUnit unit(source.units);
  const double in = DisplayUnit("in").factor(source.record.output_channel.unit);
  const double near_in = kNearShare * (limits.travel_max_in - limits.travel_min_in);
  const auto text = [&](double rod_in, double limit_in) {
    return fmt::format("the rod comes to {:.4g} {}, and the rig's limit is {:.4g} {}", unit.factor("in") * rod_in,
                       unit.of("in"), unit.factor("in") * limit_in, unit.of("in"));
  };
  const double highest_in = in * source.record.output.maxCoeff();
  const double lowest_in = in * source.record.output.minCoeff();
  if (highest_in > limits.travel_max_in - near_in) return text(highest_in, limits.travel_max_in);
  return lowest_in < limits.travel_min_in + near_in ? text(lowest_in, limits.travel_min_in) : std::string();
}

}  // namespace

std::string at_command_limit(const Source& source) {
  constexpr double kFullShare = 0.9;
  if (source.record.input.size() == 0) return {};
  try {
    const std::optional<config::RigConfig> rig = rig_of(source);
    if (!rig) return {};
    if (const std::string near = near_travel_limit(source, *rig); !near.empty()) return near;
    const double up = source.record.input.maxCoeff() / rig->limits.command_max_V;
    const double down = source.record.input.minCoeff() / rig->limits.command_min_V;
    if (!(std::max(up, down) >= kFullShare)) return {};
    return up > down ? fmt::format("the volts reach {:.3g} V of the rig's {:g} V", source.record.input.maxCoeff(),
                                   rig->limits.command_max_V)
                     : fmt::format("the volts reach {:.3g} V of the rig's {:g} V", source.record.input.minCoeff(),
                                   rig->limits.command_min_V);
  } catch (const Error&) {  // a rig file of another version
    return {};
  }
}

std::optional<NextExperiment> longer_experiment(const Source& source, double used_s) {
  if (!source.experiment || source.experiment->text.empty()) return {};
  const config::ExperimentConfig& experiment = *source.experiment;
  const int for_length = repetitions_for(experiment, used_s);
  const int repetitions = std::max(more_repetitions(experiment), for_length);
  if (repetitions > (for_length == repetitions ? kMostForLength : kMostRepetitions)) return {};
  const auto doubled = [&](const std::string& text) {
    return with_number(text, "repetitions", repetitions, "duration_s");
  };
  NextExperiment next{
      .text = doubled(experiment.text),
      .reason =
          for_length == repetitions
              ? fmt::format("{} repetitions instead of {} make it {:.3g} s long; {:.3g} s or more are asked for",
                            repetitions, experiment.repetitions, repetitions * experiment.duration_s,
                            used_s + experiment.fit.discard_s)
              : fmt::format("{} repetitions instead of {} {} the part of each estimate's variance that noise causes",
                            repetitions, experiment.repetitions,
                            repetitions == 2 * experiment.repetitions ? "halve" : "lessen")};
  try {
    const std::optional<config::RigConfig> rig = rig_of(source);
    const auto same = rig ? std::optional(prepared(next.text, *rig)) : std::nullopt;
    const bool is_allowed = !same || passes(rehearsed(*same, *rig));
    const auto weak_V = same ? reach_within_dead_band(*same, *rig) : std::nullopt;
    if (same && for_length == repetitions && has_few_tones(*same, rig->realtime.sample_period_s)) {
      const config::ExperimentConfig longer = in_two_pieces(experiment, used_s + experiment.fit.discard_s);
      if (std::string text = text_with_tones(longer, *rig); !text.empty()) {
        next.text = std::move(text);
        next.what = "a longer experiment with more tones";
        next.reason = fmt::format(
            "three tones in {:g} s; {:.3g} s or more are asked for, and fewer tones do not tell the structures apart",
            2.0 * longer.duration_s, used_s + experiment.fit.discard_s);
        return next;
      }
    }
    if (same && (!is_allowed || weak_V || moves_rarely(*same))) {
      config::ExperimentConfig longer = experiment;
      longer.text = next.text;
      next.text = text_with_tones(longer, *rig);
      if (next.text.empty()) return {};
      next.what = weak_V ? "an experiment with greater tones" : "an experiment with a multisine";
      next.reason = weak_V ? reach_text(*weak_V, *rig) +
                                 ": greater tones move the rod, and in the rehearsal stay clear of the rig's limits"
                           : fmt::format(
                                 "a multisine moves the input all the time, and in the rehearsal it stays clear of the "
                                 "rig's limits{}",
                                 is_allowed ? "" : ", which the same experiment with more repetitions does not");
    }
    const auto read = config::parse_experiment(next.text, std::string(kNextExperimentFile), config::NamedFiles::leave);
    if (read.repetitions != repetitions) return {};
  } catch (const Error&) {
    return {};
  }
  return next;
}

}  // namespace eha::identify
