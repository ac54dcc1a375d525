// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ident/excitation/portable_draw.hpp"

namespace eha::ident::nonlinear {

/// A lag with a resonance, y_k = a1 y_(k-1) + a2 y_(k-2) + b x_(k-1), gain 1 at rest.
struct Resonance {
  double radius = 0.9;
  double angle_rad = 0.15;

  [[nodiscard]] Eigen::VectorXd response(const Eigen::VectorXd& x) const {
    const double a1 = 2.0 * radius * std::cos(angle_rad);
    const double a2 = -radius * radius;
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
    for (Eigen::Index k = 1; k < x.size(); ++k) {
      y[k] = a1 * y[k - 1] + (k > 1 ? a2 * y[k - 2] : 0.0) + (1.0 - a1 - a2) * x[k - 1];
    }
    return y;
  }
};

enum class Kind { hammerstein, wiener, friction };

/// A plant of drawn parameters: a polynomial or a dead band before or behind a resonance, or a spring, mass and damper
/// with dry friction.
struct Plant {
  Kind kind = Kind::hammerstein;
  Resonance linear;
  double square = 0.0;
  double cube = 0.0;
  double dead_band = 0.0;
  double dry_friction = 0.0;  ///< over the stiffness
  double natural_rad_s = 15.0;

  [[nodiscard]] Eigen::VectorXd response(const Eigen::VectorXd& u) const {
    switch (kind) {
      case Kind::hammerstein:
        return linear.response(bent(u));
      case Kind::wiener:
        return bent(linear.response(u));
      case Kind::friction:
        break;
    }
    return rubbed(u);
  }

 private:
  [[nodiscard]] Eigen::VectorXd bent(const Eigen::VectorXd& x) const {
    return x.unaryExpr([this](double v) {
      const double passed = std::copysign(std::max(std::abs(v) - dead_band, 0.0), v);
      return passed + square * passed * passed + cube * passed * passed * passed;
    });
  }

  /// x'' = w^2 (u - x - dry_friction tanh(x' / 0.5)) - 1.4 w x', 8 steps a sample of 0.01 s.
  [[nodiscard]] Eigen::VectorXd rubbed(const Eigen::VectorXd& u) const {
    constexpr int kSteps = 8;
    constexpr double kStep_s = 0.01 / kSteps;
    const double w = natural_rad_s;
    Eigen::VectorXd y(u.size());
    double x = 0.0;
    double v = 0.0;
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      y[k] = x;
      for (int i = 0; i < kSteps; ++i) {
        v += kStep_s * (w * w * (u[k] - x - dry_friction * std::tanh(v / 0.5)) - 1.4 * w * v);
        x += kStep_s * v;
      }
    }
    return y;
  }
};

/// The plant of a number: the kinds take turns.
inline Plant plant(int number) {
  PortableDraw draw(static_cast<std::uint64_t>(1000 + number));
  const auto between = [&](double low, double high) { return low + (high - low) * draw.uniform(); };
  Plant plant;
  plant.kind = static_cast<Kind>(number % 3);
  plant.linear = {between(0.75, 0.93), between(0.05, 0.3)};
  plant.square = between(0.01, 0.06);
  plant.cube = between(-0.03, 0.03);
  plant.dead_band = number % 2 == 0 ? between(0.05, 0.25) : 0.0;
  plant.dry_friction = between(0.1, 0.4);
  plant.natural_rad_s = between(10.0, 25.0);
  return plant;
}

}  // namespace eha::ident::nonlinear
