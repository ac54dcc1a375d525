// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/rehearsal/rehearsal.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "config/hold_law.hpp"
#include "config/measured_check.hpp"
#include "config/stopping_distance.hpp"
#include "config/valve_estimate.hpp"
#include "hal/backends/backend.hpp"
#include "ident/excitation/portable_draw.hpp"

namespace eha {
namespace {

constexpr int kDraws = 200;
constexpr double kStep_s = 0.005;
constexpr double kMostHidden_in = 0.01;
constexpr double kShareWithin = 0.95;

/// Range of a rod's positions, and whether the tick would have stopped it.
struct Passage {
  double lowest_in = 0.0;
  double highest_in = 0.0;
  bool trips = false;
};

/// Returns the ticks of a step of the rehearsal. A table that is no line between the ends of its steps moves the rod by
/// more than they show: then 1.
Eigen::Index ticks_of_step(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  const Eigen::VectorXd& table_V = experiment.table_V;
  const double tick_s = rig.realtime.sample_period_s;
  const Eigen::Index ticks = std::max<Eigen::Index>(1, std::llround(kStep_s / tick_s));
  if (ticks == 1 || !rig.limits.following) return ticks;
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const double gain = std::max(valve.gain_positive_in_per_V_s, valve.gain_negative_in_per_V_s);
  double hidden_V_s = 0.0;
  for (Eigen::Index k = 0; k + ticks < table_V.size(); k += ticks) {
    const Eigen::ArrayXd line = Eigen::ArrayXd::LinSpaced(ticks + 1, table_V[k], table_V[k + ticks]);
    hidden_V_s += tick_s * (table_V.segment(k, ticks + 1).array() - line).abs().sum();
  }
  return gain * experiment.config.repetitions * hidden_V_s > kMostHidden_in ? 1 : ticks;
}

class Play {
 public:
  Play(const config::PreparedExperiment& experiment, const config::RigConfig& rig)
      : experiment_(experiment),
        limits_(rig.limits),
        ticks_(ticks_of_step(experiment, rig)),
        tick_s_(rig.realtime.sample_period_s),
        step_s_(static_cast<double>(ticks_) * tick_s_),
        from_V_(limits_.safe_V),
        ramp_steps_(
            1 + static_cast<int>((limits_.command_max_V - limits_.command_min_V) / (limits_.slew_V_per_s * step_s_))) {
    const config::Played* played = experiment.config.played();
    if (played == nullptr) return;
    // A placing leaves the command at the null.
    if ((played->start || config::shows_motion_first(rig)) && limits_.following) from_V_ = limits_.following->null_V;
    if (!played->hold) return;
    hold_ = config::hold_law(limits_, played->hold->gain_V_per_in.value_or(config::hold_gains(rig).usual));
  }

  [[nodiscard]] Passage on(const config::ValveEstimate& valve, double start_in) const {
    const Eigen::VectorXd& table_V = experiment_.table_V;
    Rod rod{.passage = {.lowest_in = start_in, .highest_in = start_in}, .place_in = start_in, .command_V = from_V_};
    const double middle_in = hold_ ? start_in - experiment_.predicted_in[0] : 0.0;
    const auto wanted_V = [&](Eigen::Index k) {
      const double off_in = hold_ ? middle_in + experiment_.predicted_in[k] - rod.place_in : 0.0;
      return std::clamp(table_V[k] + (hold_ ? hold_->correction_V(off_in) : 0.0), limits_.command_min_V,
                        limits_.command_max_V);
    };
    for (int i = 0; i < ramp_steps_ && ramps(rod, wanted_V(0)); ++i) move(rod, valve, wanted_V(0));
    for (int repetition = 0; repetition < experiment_.config.repetitions && !rod.passage.trips; ++repetition) {
      for (Eigen::Index k = 0; k < table_V.size() && !rod.passage.trips; k += ticks_) move(rod, valve, wanted_V(k));
    }
    for (int i = 0; i < ramp_steps_ && ramps(rod, limits_.safe_V); ++i) move(rod, valve, limits_.safe_V);
    return rod.passage;
  }

 private:
  struct Rod {
    Passage passage;
    double place_in = 0.0;
    double command_V = 0.0;
  };

  /// Whether a voltage is more than one step away.
  [[nodiscard]] bool ramps(const Rod& rod, double wanted_V) const {
    return !rod.passage.trips && std::abs(wanted_V - rod.command_V) > limits_.slew_V_per_s * step_s_;
  }

  /// One step, in which the command goes towards a voltage at the slew limit.
  void move(Rod& rod, const config::ValveEstimate& valve, double wanted_V) const {
    const double most_V = limits_.slew_V_per_s * step_s_;
    rod.command_V += std::clamp(wanted_V - rod.command_V, -most_V, most_V);
    const double velocity = valve.velocity_in_per_s(rod.command_V);
    rod.place_in += step_s_ * velocity;
    rod.passage.lowest_in = std::min(rod.passage.lowest_in, rod.place_in);
    rod.passage.highest_in = std::max(rod.passage.highest_in, rod.place_in);
    rod.passage.trips = is_beyond(rod.place_in, velocity);
  }

  [[nodiscard]] bool is_beyond(double place_in, double velocity) const {
    if (std::abs(velocity) > limits_.velocity_limit_in_per_s) return true;
    const double stopping_in = config::stopping_distance_in(limits_, tick_s_, std::abs(velocity));
    return place_in + (velocity > 0.0 ? stopping_in : 0.0) > limits_.travel_max_in ||
           place_in - (velocity < 0.0 ? stopping_in : 0.0) < limits_.travel_min_in;
  }

  const config::PreparedExperiment& experiment_;
  const config::RigLimits& limits_;
  Eigen::Index ticks_;
  double tick_s_;
  double step_s_;
  double from_V_;   ///< command before the ramp to the first row
  int ramp_steps_;  ///< most of a ramp
  std::optional<config::HoldLaw> hold_;
};

config::ValveEstimate drawn(const config::ValveEstimate& valve, const config::ValveUncertainty& uncertainty,
                            ident::PortableDraw& draw) {
  config::ValveEstimate other = valve;
  other.null_V += uncertainty.null_V * draw.normal();
  other.dead_band_V = std::max(0.0, other.dead_band_V + uncertainty.dead_band_V * draw.normal());
  other.gain_positive_in_per_V_s *= std::max(0.1, 1.0 + uncertainty.gain_share * draw.normal());
  other.gain_negative_in_per_V_s *= std::max(0.1, 1.0 + uncertainty.gain_share * draw.normal());
  return other;
}

double mean_velocity(const config::ValveEstimate& valve, const Eigen::Ref<const Eigen::VectorXd>& volts_V,
                     double offset_V) {
  double sum = 0.0;
  for (const double u : volts_V) sum += valve.velocity_in_per_s(u + offset_V);
  return sum / static_cast<double>(volts_V.size());
}

/// Covers whole periods of the excitation.
Eigen::VectorXd periodic_part(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  return experiment.table_V.tail(
      config::periodic_rows(experiment.config, experiment.table_V.size(), rig.realtime.sample_period_s));
}

bool plays_open_loop(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  const config::Played* played = experiment.config.played();
  return rig.limits.following && played != nullptr && !played->hold;
}

/// Whether the excitation swings about its offset. Otherwise, like a step, it moves the rod on purpose.
bool is_balanced(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  constexpr double kOneSided = 0.25;  // mean over peak
  const Eigen::ArrayXd swing = periodic_part(experiment, rig).array() - experiment.config.played()->excitation.offset_V;
  const double peak = swing.size() == 0 ? 0.0 : swing.abs().maxCoeff();
  return peak > 0.0 && std::abs(swing.mean()) <= kOneSided * peak;
}

/// Returns the excitation's offset_V at which the rod's mean speed is 0; none within the command limits.
/// @param unexplained  speed that the valve does not explain [in/s]
std::optional<double> offset_that_stops(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                                        double unexplained) {
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const Eigen::VectorXd periods_V = periodic_part(experiment, rig);
  const auto rate = [&](double offset_V) { return mean_velocity(valve, periods_V, offset_V) + unexplained; };
  // The speed rises with the offset; bisection finds where it is 0.
  double low_V = rig.limits.command_min_V - experiment.table_V.minCoeff();
  double high_V = rig.limits.command_max_V - experiment.table_V.maxCoeff();
  if (!(low_V < high_V) || rate(low_V) > 0.0 || rate(high_V) < 0.0) return std::nullopt;
  for (int i = 0; i < 40; ++i) {
    const double middle_V = 0.5 * (low_V + high_V);
    (rate(middle_V) > 0.0 ? high_V : low_V) = middle_V;
  }
  return experiment.config.played()->excitation.offset_V + 0.5 * (low_V + high_V);
}

/// Returns offset_that_stops(), if the rod then stays within the limits.
std::optional<double> offset_that_helps(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                                        double from_in) {
  if (!is_balanced(experiment, rig)) return std::nullopt;
  const std::optional<double> offset_V = offset_that_stops(experiment, rig, 0.0);
  if (!offset_V) return std::nullopt;
  config::PreparedExperiment other = experiment;
  other.table_V.array() += *offset_V - experiment.config.played()->excitation.offset_V;
  const Passage passage = Play(other, rig).on(config::valve_estimate(*rig.limits.following), from_in);
  return passage.trips ? std::nullopt : offset_V;
}

}  // namespace

double start_of(const config::RigConfig& rig) {
  return hal::initial_displacement_in(rig.backend).value_or(rig.limits.mid_travel_in());
}

std::optional<Rehearsal> rehearse(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                                  double start_in, std::uint64_t seed) {
  const config::Played* played = experiment.config.played();
  if (!rig.limits.following || played == nullptr || experiment.table_V.size() == 0) return std::nullopt;
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const config::ValveUncertainty uncertainty = config::valve_uncertainty(*rig.limits.following);
  const double ahead_in = played->hold ? experiment.predicted_in[0] : 0.0;
  const double shown_in =
      config::shows_motion_first(rig) ? config::kShowingLeaves * config::showing_way_in(rig.limits, start_in) : 0.0;
  const double from_in = played->start ? played->start->displacement_in + ahead_in : start_in + shown_in;
  const Play play(experiment, rig);
  ident::PortableDraw draw(seed);
  std::vector<double> lowest(kDraws);
  std::vector<double> highest(kDraws);
  int trips = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Passage passage = play.on(drawn(valve, uncertainty, draw), from_in);
    lowest[static_cast<std::size_t>(i)] = passage.lowest_in;
    highest[static_cast<std::size_t>(i)] = passage.highest_in;
    trips += passage.trips ? 1 : 0;
  }
  std::sort(lowest.begin(), lowest.end());
  std::sort(highest.begin(), highest.end());
  constexpr auto kLow = static_cast<std::size_t>((1.0 - kShareWithin) * kDraws);
  constexpr auto kHigh = static_cast<std::size_t>(kShareWithin * kDraws) - 1;
  const bool is_open = plays_open_loop(experiment, rig);
  return Rehearsal{
      .lowest_in = lowest[kLow],
      .highest_in = highest[kHigh],
      .drift_in_per_s = is_open ? mean_velocity(valve, periodic_part(experiment, rig), 0.0) : 0.0,
      .chance_of_trip = static_cast<double>(trips) / kDraws,
      .still_offset_V = is_open ? offset_that_helps(experiment, rig, from_in) : std::nullopt,
      .offset_has_no_room = is_open && is_balanced(experiment, rig) && !offset_that_stops(experiment, rig, 0.0)};
}

bool is_clear_from_mid_travel(const config::PreparedExperiment& experiment, const config::RigConfig& rig) {
  const config::Played* played = experiment.config.played();
  if (played == nullptr || played->start) return false;
  const std::optional<Rehearsal> rehearsal = rehearse(experiment, rig, rig.limits.mid_travel_in());
  return rehearsal && rehearsal->chance_of_trip < kWarnedChanceOfTrip;
}

std::optional<double> reach_within_dead_band(const config::PreparedExperiment& experiment,
                                             const config::RigConfig& rig) {
  constexpr double kLittle = 2.0;  // of the dead band
  if (!rig.limits.following || experiment.table_V.size() == 0) return std::nullopt;
  const double reach_V = (experiment.table_V.array() - rig.limits.following->null_V).abs().maxCoeff();
  return reach_V < kLittle * rig.limits.following->dead_band_V ? std::optional(reach_V) : std::nullopt;
}

std::optional<Drift> drift_of(const config::PreparedExperiment& experiment, const config::RigConfig& rig,
                              const Eigen::Ref<const Eigen::VectorXd>& displacement_in) {
  if (!plays_open_loop(experiment, rig) || displacement_in.size() < 2) return std::nullopt;
  if (!is_balanced(experiment, rig)) return std::nullopt;
  const config::ValveEstimate valve = config::valve_estimate(*rig.limits.following);
  const Eigen::VectorXd& table_V = experiment.table_V;
  const double step_s = rig.realtime.sample_period_s;
  const Eigen::Index rows = displacement_in.size();
  double explained_in = 0.0;
  for (Eigen::Index k = 0; k + 1 < rows; ++k) {
    explained_in += step_s * valve.velocity_in_per_s(table_V[k % table_V.size()]);
  }
  const double moved_in = displacement_in[rows - 1] - displacement_in[0];
  const double unexplained = (moved_in - explained_in) / (static_cast<double>(rows - 1) * step_s);
  return Drift{.rate_in_per_s = mean_velocity(valve, periodic_part(experiment, rig), 0.0) + unexplained,
               .offset_V = offset_that_stops(experiment, rig, unexplained)};
}

}  // namespace eha
