// SPDX-License-Identifier: GPL-3.0-or-later
// A mass with viscous and Coulomb friction:
//   lag_s w' = gain (v - friction sgn w) - w, z' = w,
// which sticks at w = 0 while |v| <= friction. friction [input unit] is that of either direction about the null
// -input_bias: two levels that differ move the null. Without friction it is gain / (s (lag_s s + 1)).
#include <algorithm>
#include <cmath>

#include "ident/grey_box/grey_box_kind.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kSpeedGain = 0;
constexpr std::size_t kLag = 1;
constexpr std::size_t kFriction = 2;
constexpr std::array kFrictionParameters{GreyBoxParameter{"gain", GreyBoxUnit::rate_gain, false},
                                         GreyBoxParameter{"lag_s", GreyBoxUnit::seconds},
                                         GreyBoxParameter{"friction", GreyBoxUnit::input}};
constexpr std::array kShares{0.1, 0.3, 0.8};  // of the input's rms, for starts
constexpr int kMostPieces = 4;                // a held input turns the motion at most once

/// Exact: the velocity is an exponential until it is 0, where the mass sticks or turns.
void advance_friction(const double* values, double* state, double v, double duration_s) {
  const double lag_s = values[kLag];
  const double friction = values[kFriction];
  double left_s = duration_s;
  for (int piece = 0; piece < kMostPieces && left_s > 0.0; ++piece) {
    double& w = state[1];
    double side = w > 0.0 ? 1.0 : -1.0;
    if (std::abs(w) <= 0.0) {
      if (std::abs(v) <= friction) return;
      side = values[kSpeedGain] * v > 0.0 ? 1.0 : -1.0;
    }
    // Friction acts against the motion; a negative gain moves against its input.
    const double end = values[kSpeedGain] * v - std::abs(values[kSpeedGain]) * friction * side;
    double over_s = left_s;
    const bool turns = end * side < 0.0;
    if (turns) over_s = std::min(left_s, lag_s * std::log1p(-w / end));
    const double decay = -std::expm1(-over_s / lag_s);
    state[0] += end * over_s + (w - end) * lag_s * decay;
    w += (end - w) * decay;
    if (turns && over_s < left_s) w = 0.0;
    left_s -= over_s;
  }
}

LinearForm while_moving(std::span<const double> values) { return {values[kSpeedGain], {0.0, 1.0, values[kLag]}}; }

std::vector<std::vector<double>> friction_starts(const GreyBoxStart& start) {
  const double speed = start.linear.denominator[1];
  std::vector<std::vector<double>> all;
  for (const double share : kShares) {
    // The mass moves by what the friction leaves of the input.
    all.push_back({start.linear.gain / speed / (1.0 - 0.5 * share), start.linear.denominator[2] / speed,
                   share * start.input_rms});
  }
  return all;
}

}  // namespace

const GreyBoxKind& friction_kind() {
  static const GreyBoxKind kKind{.name = "friction",
                                 .formula = "mass with Coulomb friction",
                                 .effect = "dry friction",
                                 .parameters = kFrictionParameters,
                                 .states = 2,
                                 .integrates = true,
                                 .advance = advance_friction,
                                 .linearised = while_moving,
                                 .starts = friction_starts};
  return kKind;
}

}  // namespace eha::ident
