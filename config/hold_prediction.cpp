// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cstddef>

#include "config/prepared_experiment.hpp"
#include "config/stopping_distance.hpp"
#include "config/valve_estimate.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/signal/periods.hpp"

namespace eha::config {
namespace {

constexpr double kUsual_per_s = 0.75;
constexpr double kMost_per_s = 1.0;
constexpr double kPlacingSpare_in = 0.04;

}  // namespace

Eigen::Index periodic_rows(const ExperimentConfig& experiment, Eigen::Index table_rows, double tick_s) {
  const Played* played = experiment.played();
  if (experiment.repetitions > 1 || played == nullptr) return table_rows;
  const auto rows = static_cast<std::size_t>(table_rows);
  const std::size_t period = ident::common_period(ident::excited_lines(played->excitation, tick_s, rows), tick_s, rows);
  return period == 0 ? table_rows : static_cast<Eigen::Index>(rows / period * period);
}

Eigen::VectorXd predicted_displacement(const ExperimentConfig& experiment, const RigConfig& rig,
                                       const Eigen::Ref<const Eigen::VectorXd>& table_V) {
  const ValveEstimate valve = valve_estimate(rig.limits.following.value());
  const double step_s = rig.realtime.sample_period_s;
  const Eigen::Index rows = periodic_rows(experiment, table_V.size(), step_s);
  Eigen::VectorXd velocity(table_V.size());
  for (Eigen::Index k = 0; k < table_V.size(); ++k) velocity[k] = valve.velocity_in_per_s(table_V[k]);
  velocity.array() -= velocity.tail(rows).mean();
  Eigen::VectorXd displacement(table_V.size());
  double sum_in = 0.0;
  for (Eigen::Index k = 0; k < table_V.size(); ++k) {
    displacement[k] = sum_in;
    sum_in += step_s * velocity[k];
  }
  displacement.array() -= displacement.tail(rows).mean();
  return displacement;
}

HoldGains hold_gains(const RigConfig& rig) {
  const ValveEstimate valve = valve_estimate(rig.limits.following.value());
  const double gain = std::max(valve.gain_positive_in_per_V_s, valve.gain_negative_in_per_V_s);
  return {.usual = kUsual_per_s / gain, .most = kMost_per_s / gain};
}

double placing_margin_in(const RigConfig& rig) {
  return kPlacingSpare_in + stopping_distance_in(rig.limits, rig.realtime.sample_period_s, 0.0);
}

}  // namespace eha::config
