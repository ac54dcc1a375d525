// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/place/prediction_monitor.hpp"

#include <algorithm>
#include <cmath>

namespace eha::place {
namespace {

using acquisition::Fault;

// Pinned by dead_sensor_campaign_test.cpp.
constexpr std::array<double, 2> kDirections{1.0, -1.0};
constexpr double kForgets_s = 20.0;  ///< of motion
constexpr double kSlow_V = 0.02;     ///< that the filter trails the command by: 0.4 V/s
constexpr double kLeast_in_per_s = 0.014;
constexpr double kMost_in_per_s = 0.2;
constexpr double kLeastWeight_s = 3.0;
constexpr double kLeastSpread_in_per_s = 0.01;
constexpr double kLeastOfAssumed = 0.4;  ///< a cylinder's areas differ by less
constexpr double kLeastShare = 0.4;
constexpr double kLate_V = 0.02;
constexpr double kMissing_in = 0.03;
constexpr double kMostShare = 2.5;
constexpr double kEarly_V = 0.03;
constexpr double kFloor_in_per_s = 0.05;
constexpr double kExcess_in = 0.05;

}  // namespace

PredictionMonitor::PredictionMonitor(double period_s) noexcept
    : period_s_(period_s), kept_(1.0 - period_s / kForgets_s), motion_(period_s) {}

void PredictionMonitor::note(double command_V, double displacement_in) noexcept {
  motion_.note(command_V, displacement_in);
  if (learns_) learn();
  check(0);
  check(1);
}

void PredictionMonitor::learn() noexcept {
  const std::size_t i = motion_.speed_in_per_s() > 0.0 ? 0 : 1;
  const double v = std::abs(motion_.speed_in_per_s());
  const double u = kDirections[i] * motion_.command_V();
  if (v < kLeast_in_per_s || v > kMost_in_per_s || std::abs(motion_.trails_by_V()) > kSlow_V) return;
  ForgettingLine& fit = fits_[i];
  fit.add(kept_, period_s_, u, v);
  if (fit.weight_s() < kLeastWeight_s) return;
  const bool spreads = fit.variance_y() >= kLeastSpread_in_per_s * kLeastSpread_in_per_s;
  if (!spreads || fit.covariance() <= 0.0 || fit.variance_x() <= 0.0) return;
  const double gain = fit.slope();
  lines_[i] = FlowLine{.gain_in_per_V_s = gain, .edge_V = fit.mean_x() - fit.mean_y() / gain};
}

void PredictionMonitor::stop_learning(const FlowLine& extending, const FlowLine& retracting) noexcept {
  learns_ = false;
  const std::array<FlowLine, 2> assumed{extending, retracting};
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const bool is_known = lines_[i] && lines_[i]->gain_in_per_V_s >= kLeastOfAssumed * assumed[i].gain_in_per_V_s;
    if (!is_known) lines_[i] = assumed[i];
  }
}

void PredictionMonitor::check(std::size_t i) noexcept {
  if (!lines_[i]) return;
  const FlowLine& line = *lines_[i];
  const double outside_V = kDirections[i] * motion_.command_V() - line.edge_V;
  const double speed = kDirections[i] * motion_.speed_in_per_s();
  if (const double due = kLeastShare * line.gain_in_per_V_s * (outside_V - kLate_V); due > 0.0) {
    missing_in_[i] = std::max(0.0, missing_in_[i] + (due - std::max(0.0, speed)) * period_s_);
    due_in_[i] = missing_in_[i] > 0.0 ? due_in_[i] + due * period_s_ : 0.0;
    due_s_[i] = missing_in_[i] > 0.0 ? due_s_[i] + period_s_ : 0.0;
    if (missing_in_[i] > kMissing_in) {
      trip({Fault::no_motion, due_in_[i] - missing_in_[i], due_in_[i], motion_.command_V(), due_s_[i]});
    }
  }
  const double most = kMostShare * line.gain_in_per_V_s * std::max(0.0, outside_V + kEarly_V) + kFloor_in_per_s;
  excess_in_[i] = std::max(0.0, excess_in_[i] + (speed - most) * period_s_);
  if (excess_in_[i] > kExcess_in) trip({Fault::unexplained_motion, excess_in_[i], kExcess_in});
}

void PredictionMonitor::trip(const acquisition::Breach& breach) noexcept {
  if (breach_.fault == Fault::none) breach_ = breach;
}

}  // namespace eha::place
