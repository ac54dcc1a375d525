// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "ident/fractional/simulate.hpp"
#include "ident/signal/valve_map.hpp"
#include "tests/unit/ident/synthetic_record.hpp"

/// Plants of drawn parameters, on the ladder of structures and outside of it, and records of them.
namespace eha::ident::random_plants {

using synthetic::normal;
using synthetic::uniform;
using Draw = std::mt19937_64;
using Plant = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;  ///< noise-free output of an input

constexpr double kStep_s = 0.04;

inline double between(double low, double high, Draw& draw) { return low + (high - low) * uniform(draw); }
inline double log_between(double low, double high, Draw& draw) {
  return std::exp(between(std::log(low), std::log(high), draw));
}

enum class Input { levels, two_levels, tones };

/// @param rows  of kStep_s
inline Eigen::VectorXd input(Input kind, double peak, Eigen::Index rows, Draw& draw) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(rows);
  if (kind == Input::tones) {
    for (double lowest_Hz = 0.05; lowest_Hz < 3.0; lowest_Hz *= 1.6) {
      const double w = 2.0 * std::numbers::pi * lowest_Hz * between(1.0, 1.5, draw) * kStep_s;
      const double phase = between(0.0, 2.0 * std::numbers::pi, draw);
      for (Eigen::Index k = 0; k < rows; ++k) u[k] += std::cos(w * static_cast<double>(k) + phase);
    }
    return u * (peak / u.cwiseAbs().maxCoeff());
  }
  for (Eigen::Index k = 0; k < rows;) {
    const double level = kind == Input::levels ? between(-peak, peak, draw) : uniform(draw) < 0.5 ? -peak : peak;
    const auto end = std::min(rows, k + 3 + static_cast<Eigen::Index>(between(0.0, 30.0, draw)));
    while (k < end) u[k++] = level;
  }
  return u;
}

struct Truth {
  std::string kind;
  Plant plant;
  std::string family;  ///< of the ladder; empty: outside of it
};

inline Plant linear(const TransferFunction& g) {
  return [g](const Eigen::VectorXd& u) { return simulate(g, u, kStep_s); };
}
inline Plant behind(const TransferFunction& g, std::function<double(double)> map) {
  return [g, map = std::move(map)](const Eigen::VectorXd& u) {
    return simulate(g, Eigen::VectorXd(u.unaryExpr(map)), kStep_s);
  };
}

/// K/(a2 s^2 + s + a0) whose dominant mode the record shows.
inline TransferFunction two_poles(Draw& draw) {
  const double w = log_between(1.0, 8.0, draw);
  const double damping = log_between(0.25, 1.5, draw);
  return {{{1.0, 0.0}}, {{1.0 / (2.0 * damping * w), 2.0}, {1.0, 1.0}, {w / (2.0 * damping), 0.0}}, 0.0};
}

inline std::vector<std::string> kinds_inside() {
  return {
      "cylinder", "cylinder_valve", "zero", "right_zero", "integrator_delay", "integrator_lag", "io1", "io", "io_delay",
      "io3",      "io_valve",       "lag",  "fo",         "fo_zero"};
}

inline Truth inside(const std::string& kind, Draw& draw) {
  const double gain = log_between(0.3, 3.0, draw);
  const double w = log_between(3.0, 15.0, draw);
  const double d = log_between(0.05, 0.5, draw);
  const TransferFunction cylinder{
      {{gain, 0.0}}, {{1.0 / (w * w), 3.0}, {2.0 * d / w, 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0};
  TransferFunction g = two_poles(draw);
  const ValveMap valve{between(-0.3, 0.3, draw), between(0.1, 0.4, draw), between(0.7, 1.3, draw)};
  const auto through = [valve](double u) { return mapped(valve, Eigen::VectorXd::Constant(1, u))[0]; };
  if (kind == "cylinder") return {kind, linear(cylinder), "cylinder"};
  if (kind == "cylinder_valve") return {kind, behind(cylinder, through), "cylinder_valve"};
  if (kind == "zero" || kind == "right_zero") {
    const double tau = between(0.3, 1.2, draw) * g.denominator[0].coefficient * (kind == "zero" ? 3.0 : -2.0);
    g.numerator = {{tau, 1.0}, {1.0, 0.0}};
    return {kind, linear(g), "io"};
  }
  if (kind == "integrator_delay") {
    return {kind, linear({{{gain, 0.0}}, {{1.0, 1.0}, {0.0, 0.0}}, between(0.1, 0.5, draw)}), "integrator_lag"};
  }
  if (kind == "integrator_lag") {
    return {kind, linear({{{gain, 0.0}}, {{between(0.1, 0.5, draw), 2.0}, {1.0, 1.0}, {0.0, 0.0}}, 0.0}),
            "integrator_lag"};
  }
  if (kind == "io1") return {kind, linear({{{gain, 0.0}}, {{1.0, 1.0}, {between(0.3, 3.0, draw), 0.0}}, 0.0}), "io1"};
  if (kind == "io") return {kind, linear(g), "io"};
  if (kind == "io_delay") {
    g.delay_s = between(0.1, 0.4, draw);
    return {kind, linear(g), "io"};
  }
  if (kind == "io_valve") return {kind, behind(g, through), "io_valve"};
  if (kind == "io3") {
    const double fast = between(0.05, 0.2, draw);
    const double a2 = g.denominator[0].coefficient;
    const double a0 = g.denominator[2].coefficient;
    g.denominator = {{a2 * fast, 3.0}, {a2 + fast, 2.0}, {1.0 + a0 * fast, 1.0}, {a0, 0.0}};
    return {kind, linear(g), "io3"};
  }
  if (kind == "lag") {
    return {kind, linear({{{gain, 0.0}}, {{1.0, between(0.55, 0.85, draw)}, {between(0.3, 3.0, draw), 0.0}}, 0.0}),
            "lag"};
  }
  g.denominator[0].order = between(1.55, 1.8, draw);
  g.denominator[1].order = between(0.75, 0.9, draw);
  if (kind == "fo_zero") g.numerator = {{between(0.1, 0.3, draw), 1.0}, {1.0, 0.0}};
  return {kind, linear(g), "fo"};
}

inline std::vector<std::string> kinds_outside() {
  return {"saturation", "backlash", "rate_limit", "cubic_sensor",  "square_root_valve",
          "bouc_wen",   "friction", "gain_step",  "position_gain", "quadratic_valve"};
}

/// x'' + 2 D w x' + w^2 x = w^2 (u - force(x, x')), 20 steps a row.
inline Plant mechanical(double w, double damping, std::function<double(double, double, double)> force_after) {
  return [=](const Eigen::VectorXd& u) {
    constexpr int kSteps = 20;
    constexpr double h = kStep_s / kSteps;
    Eigen::VectorXd y(u.size());
    double x = 0.0;
    double v = 0.0;
    double z = 0.0;  // of a force that remembers
    for (Eigen::Index k = 0; k < u.size(); ++k) {
      y[k] = x;
      for (int i = 0; i < kSteps; ++i) {
        z += h * force_after(z, x, v);
        v += h * (w * w * (u[k] - x - z) - 2.0 * damping * w * v);
        x += h * v;
      }
    }
    return y;
  };
}

/// @param peak  of the input
inline Truth outside(const std::string& kind, double peak, Draw& draw) {
  const TransferFunction g = two_poles(draw);
  const double size = between(0.3, 1.0, draw);
  if (kind == "saturation") {
    const double limit = peak * between(0.4, 0.8, draw);
    return {kind, behind(g, [=](double u) { return std::clamp(u, -limit, limit); }), {}};
  }
  if (kind == "square_root_valve") {
    return {kind, behind(g, [=](double u) { return std::copysign(std::sqrt(std::abs(u) / peak), u); }), {}};
  }
  if (kind == "quadratic_valve") {
    return {kind, behind(g, [=](double u) { return u + size * u * std::abs(u) / peak; }), {}};
  }
  if (kind == "cubic_sensor") {
    return {kind,
            [=](const Eigen::VectorXd& u) {
              const Eigen::VectorXd y = simulate(g, u, kStep_s);
              return Eigen::VectorXd(y.array() + 0.3 * size * y.array().cube() / (peak * peak));
            },
            {}};
  }
  if (kind == "backlash" || kind == "rate_limit") {
    const double width = peak * between(0.1, 0.35, draw);
    const double rate = peak * between(0.05, 0.15, draw);
    const bool is_backlash = kind == "backlash";
    return {kind,
            [=](const Eigen::VectorXd& u) {
              Eigen::VectorXd v(u.size());
              double now = 0.0;
              for (Eigen::Index k = 0; k < u.size(); ++k) {
                now = is_backlash ? std::clamp(now, u[k] - width, u[k] + width)
                                  : now + std::clamp(u[k] - now, -rate, rate);
                v[k] = now;
              }
              return simulate(g, v, kStep_s);
            },
            {}};
  }
  const double w = log_between(2.0, 6.0, draw);
  const double damping = log_between(0.3, 1.0, draw);
  if (kind == "bouc_wen") {
    return {kind,
            mechanical(w, damping,
                       [=](double z, double, double v) {
                         return size * v - 2.0 / peak * (std::abs(v) * z + 0.2 * v * std::abs(z));
                       }),
            {}};
  }
  if (kind == "friction") {
    const double force = peak * between(0.05, 0.2, draw);
    return {kind,
            mechanical(w, damping,
                       [=](double z, double, double v) { return 200.0 * (force * std::tanh(20.0 * v / peak) - z); }),
            {}};
  }
  if (kind == "gain_step") {
    return {kind,
            [=](const Eigen::VectorXd& u) {
              Eigen::VectorXd v = u;
              v.tail(u.size() / 2) *= 1.0 + size;
              return simulate(g, v, kStep_s);
            },
            {}};
  }
  // position_gain: the spring stiffens
  return {kind,
          mechanical(w, damping,
                     [=](double z, double x, double) { return 200.0 * (0.5 * size * x * std::abs(x) / peak - z); }),
          {}};
}

enum class Noise { white, coloured };

inline Record record_of(const Plant& plant, const Eigen::VectorXd& u, Noise noise, double share, Draw& draw) {
  Record record;
  record.step_s = kStep_s;
  record.input = u;
  record.output = plant(u);
  const double spread = std::sqrt((record.output.array() - record.output.mean()).square().mean());
  const double pole = noise == Noise::white ? 0.0 : 0.9;
  double e = normal(draw);
  for (double& y : record.output) {
    y += share * spread * e;
    e = pole * e + std::sqrt(1.0 - pole * pole) * normal(draw);
  }
  return record;
}

/// What a model is off by on an input, its offset apart, over the output's standard deviation [%].
inline double error_percent(const Model& model, const Plant& plant, const Eigen::VectorXd& u) {
  const Eigen::VectorXd y = plant(u);
  Eigen::VectorXd e = y - simulate(model, u, kStep_s);
  e.array() -= e.mean();
  return 100.0 * e.norm() / (y.array() - y.mean()).matrix().norm();
}

}  // namespace eha::ident::random_plants
