// SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/valve/sheet_parts.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kPi = std::numbers::pi;
/// A natural frequency less accurate than this share is not reported.
constexpr double kWorstShare = 0.25;
/// Nor is one this far above the highest frequency played: the second order may not hold there.
constexpr double kFarthest = 1.25;
/// A fit of a response needs points at this many frequencies.
constexpr std::size_t kFewestPoints = 3;
/// Relative standard deviation of a point in addition to the sensor's noise: pressures and friction on a biased valve.
constexpr double kMethodShare = 0.01;
constexpr double kPaced = 0.95;       // of the planned amplitude
constexpr double kSignificant = 3.0;  // standard deviations

/// A sine in a signal with a parabolic trend, by least squares.
struct Tone {
  Complex amplitude;  ///< of exp(j omega t), t from the segment's first row
  double mean = 0.0;
  double variance = 0.0;  ///< of the amplitude's real or imaginary part
};

Tone tone_in(const Eigen::Ref<const Eigen::VectorXd>& signal, double omega, double step_s) {
  const Eigen::Index rows = signal.size();
  Eigen::MatrixXd basis(rows, 5);
  for (Eigen::Index k = 0; k < rows; ++k) {
    const double time_s = static_cast<double>(k) * step_s;
    const double t = 2.0 * static_cast<double>(k) / static_cast<double>(rows) - 1.0;
    basis.row(k) << 1.0, t, t * t, std::cos(omega * time_s), std::sin(omega * time_s);
  }
  const Eigen::VectorXd solution = solve_symmetric(basis.transpose() * basis, basis.transpose() * signal);
  const double squares = (signal - basis * solution).squaredNorm();
  const double variance = squares / static_cast<double>(std::max<Eigen::Index>(1, rows - 5));
  return {.amplitude = {solution[3], -solution[4]},
          .mean = solution[0] + solution[2] / 3.0,
          .variance = variance * 2.0 / static_cast<double>(rows)};
}

/// One measured value of G: both directions together.
struct Point {
  double frequency_Hz = 0.0;
  double amplitude_V = 0.0;  ///< that was played
  Complex response;
  double variance = 0.0;  ///< of its real or imaginary part
};

/// Returns velocity over command of a sine, over the static gain of its direction; none: it entered the dead band.
std::optional<Point> point_of(const Record& record, const SineSegment& sine, const ValveSheet& sheet) {
  if (sine.first + sine.rows > record.output.size()) return std::nullopt;
  const double omega = 2.0 * kPi * sine.frequency_Hz;
  const Tone command = tone_in(record.input.segment(sine.first, sine.rows), omega, record.step_s);
  const Tone place = tone_in(record.output.segment(sine.first, sine.rows), omega, record.step_s);
  const double nearest_V = std::abs(command.mean - sheet.null_V.value) - std::abs(command.amplitude);
  if (nearest_V < sheet.dead_band_V.value + sheet.dead_band_V.half_width || std::abs(command.amplitude) <= 0.0) {
    return std::nullopt;
  }
  const double gain = (sine.bias_V > 0.0 ? sheet.gain_positive_in_per_V_s : sheet.gain_negative_in_per_V_s).value;
  // The command is held for a tick: its fundamental is half a tick late.
  const Complex held = command.amplitude * std::polar(1.0, -0.5 * omega * record.step_s);
  const Complex factor = Complex(0.0, omega) / (held * gain);
  Point point{.frequency_Hz = sine.frequency_Hz,
              .amplitude_V = std::abs(command.amplitude),
              .response = place.amplitude * factor};
  const double method = kMethodShare * std::abs(point.response);
  point.variance = place.variance * std::norm(factor) + method * method;
  return point;
}

/// Points of one amplitude, the two directions of a frequency averaged.
std::vector<Point> points_of(const Record& record, const SheetPlan& plan, std::size_t level, const ValveSheet& sheet) {
  std::vector<Point> points;
  for (const SineSegment& sine : plan.sines) {
    if (sine.level != level) continue;
    const std::optional<Point> point = point_of(record, sine, sheet);
    if (!point) continue;
    Point* const last = points.empty() ? nullptr : &points.back();
    if (last != nullptr && std::abs(last->frequency_Hz - point->frequency_Hz) < 1e-9 * point->frequency_Hz) {
      last->response = 0.5 * (last->response + point->response);
      last->variance = 0.25 * (last->variance + point->variance);
    } else {
      points.push_back(*point);
    }
  }
  return points;
}

/// 1/G = p0 + p1 s + p2 s^2 with the covariance of p.
struct SecondOrder {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

SecondOrder second_order_of(const std::vector<Point>& points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  // Scaled to the highest frequency, so that the columns are of one size.
  const double scale = 2.0 * kPi * points.back().frequency_Hz;
  const auto rows_of = [&](const Point& point) {
    const double w = 2.0 * kPi * point.frequency_Hz / scale;
    Eigen::Matrix<double, 2, 3> rows;
    rows << 1.0, 0.0, -w * w, 0.0, w, 0.0;
    return rows;
  };
  const auto value_of = [](const Point& point) {
    const Complex inverse = 1.0 / point.response;
    return Eigen::Vector2d(inverse.real(), inverse.imag());
  };
  const auto weight_of = [](const Point& point) {
    return std::norm(point.response) * std::norm(point.response) / point.variance;
  };
  for (const Point& point : points) {
    const auto rows = rows_of(point);
    normal += weight_of(point) * rows.transpose() * rows;
    right += weight_of(point) * rows.transpose() * value_of(point);
  }
  SecondOrder fitted;
  const Eigen::Matrix3d inverse = normal.inverse();
  fitted.p = inverse * right;
  double squares = 0.0;
  for (const Point& point : points) {
    squares += weight_of(point) * (value_of(point) - rows_of(point) * fitted.p).squaredNorm();
  }
  const double freedom = 2.0 * static_cast<double>(points.size()) - 3.0;
  const Eigen::Vector3d scales(1.0, 1.0 / scale, 1.0 / (scale * scale));
  fitted.p = scales.cwiseProduct(fitted.p);
  fitted.covariance = std::max(1.0, squares / freedom) * (scales.asDiagonal() * inverse * scales.asDiagonal());
  return fitted;
}

/// Returns the lag p1/p0 for a valve whose play adds a phase independent of frequency: the imaginary part of 1/G is q +
/// p1 omega. None if q is not significant; p1 of the second order is then more accurate.
std::optional<double> lag_beside_play(const std::vector<Point>& points, double p0) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const Point& point : points) {
    const Eigen::Vector2d row(1.0, 2.0 * kPi * point.frequency_Hz);
    const double weight = std::norm(point.response) * std::norm(point.response) / point.variance;
    normal += weight * row * row.transpose();
    right += weight * row * (1.0 / point.response).imag();
  }
  const Eigen::Matrix2d inverse = normal.inverse();
  const Eigen::Vector2d found = inverse * right;
  if (found[0] < kSignificant * std::sqrt(inverse(0, 0))) return std::nullopt;
  return std::max(0.0, found[1] / p0);
}

using Quantity = std::function<std::optional<double>(const Eigen::Vector3d&)>;

/// Returns a function of p with its interval, by the delta method; none if it has no value.
std::optional<Measured> with_interval(const SecondOrder& fitted, const Quantity& quantity) {
  const std::optional<double> value = quantity(fitted.p);
  if (!value) return std::nullopt;
  Eigen::Vector3d gradient;
  for (Eigen::Index i = 0; i < 3; ++i) {
    Eigen::Vector3d moved = fitted.p;
    const double step = 1e-3 * std::sqrt(fitted.covariance(i, i));
    moved[i] += step;
    const std::optional<double> other = quantity(moved);
    if (!other || step <= 0.0) return std::nullopt;
    gradient[i] = (*other - *value) / step;
  }
  return Measured{*value, kInterval95 * std::sqrt(gradient.dot(fitted.covariance * gradient))};
}

/// Returns the frequency at which |p0 + p1 s + p2 s^2| is sqrt(2) times its value at `lowest_Hz`.
std::optional<double> minus_3dB_Hz(const Eigen::Vector3d& p, double lowest_Hz) {
  const auto square = [&p](double omega) {
    const double real = p[0] - p[2] * omega * omega;
    return real * real + p[1] * p[1] * omega * omega;
  };
  const double wanted = 2.0 * square(2.0 * kPi * lowest_Hz);
  // p2^2 x^2 + (p1^2 - 2 p0 p2) x + p0^2 - wanted = 0, x = omega^2
  const double a = p[2] * p[2];
  const double b = p[1] * p[1] - 2.0 * p[0] * p[2];
  const double c = p[0] * p[0] - wanted;
  const double root = b * b - 4.0 * a * c;
  if (!(a > 0.0) || !(root >= 0.0)) return std::nullopt;
  const double x = (-b + std::sqrt(root)) / (2.0 * a);
  if (!(x > 0.0)) return std::nullopt;
  return std::sqrt(x) / (2.0 * kPi);
}

std::optional<double> minus_90deg_Hz(const Eigen::Vector3d& p) {
  if (!(p[0] > 0.0) || !(p[2] > 0.0)) return std::nullopt;
  return std::sqrt(p[0] / p[2]) / (2.0 * kPi);
}

std::vector<ResponsePoint> shown(const std::vector<Point>& points) {
  std::vector<ResponsePoint> list;
  constexpr double kDegrees = 180.0 / kPi;
  for (const Point& point : points) {
    const double share = std::sqrt(point.variance) / std::abs(point.response);
    list.push_back({.frequency_Hz = point.frequency_Hz,
                    .gain_dB = 20.0 * std::log10(std::abs(point.response) / std::abs(points.front().response)),
                    .phase_deg = kDegrees * std::arg(point.response),
                    .gain_half_width_dB = kInterval95 * 20.0 / std::log(10.0) * share,
                    .phase_half_width_deg = kInterval95 * kDegrees * share});
  }
  return list;
}

}  // namespace

void measure_dynamic_part(const Record& record, const SheetPlan& plan, ValveSheet& sheet) {
  sheet.responses.clear();
  std::optional<SecondOrder> widest;
  std::optional<double> lag_s;
  for (std::size_t level = 0; level < kSheetAmplitudes.size(); ++level) {
    AmplitudeResponse response{.percent = 100.0 * kSheetAmplitudes[level]};
    for (const SineSegment& sine : plan.sines) {
      if (sine.level == level) response.amplitude_V = sine.amplitude_V;
    }
    response.is_played = plan.highest_Hz[level] > 0.0;
    const std::vector<Point> points = points_of(record, plan, level, sheet);
    if (!points.empty() && points.front().amplitude_V < kPaced * response.amplitude_V) {
      // On a fast rod of an unknown valve less is played.
      const double share = points.front().amplitude_V / response.amplitude_V;
      response.percent = std::round(10.0 * share * response.percent) / 10.0;
      response.amplitude_V = std::round(1000.0 * points.front().amplitude_V) / 1000.0;
    }
    response.points = shown(points);
    if (points.size() >= kFewestPoints) {
      const SecondOrder fitted = second_order_of(points);
      const double lowest_Hz = points.front().frequency_Hz;
      const double highest_Hz = points.back().frequency_Hz;
      const auto observed = [&](std::optional<Measured> crossing) {
        const bool is_inside = crossing && crossing->value <= highest_Hz && crossing->value >= lowest_Hz;
        return is_inside && crossing->half_width < kWorstShare * crossing->value ? crossing : std::nullopt;
      };
      response.minus_3dB_Hz =
          observed(with_interval(fitted, [&](const Eigen::Vector3d& p) { return minus_3dB_Hz(p, lowest_Hz); }));
      response.minus_90deg_Hz = observed(with_interval(fitted, minus_90deg_Hz));
      if (highest_Hz > sheet.highest_Hz) {
        sheet.highest_Hz = highest_Hz;
        widest = fitted;
        lag_s = lag_beside_play(points, fitted.p[0]);
      }
    }
    sheet.responses.push_back(std::move(response));
  }
  if (!widest) return;
  const std::optional<Measured> lag =
      with_interval(*widest, [](const Eigen::Vector3d& p) { return std::optional<double>(p[1] / p[0]); });
  if (lag_s) {
    sheet.lag_s = *lag_s;
  } else if (lag && lag->value > 0.0 && lag->half_width < 0.5 * lag->value) {
    sheet.lag_s = lag->value;
  }
  const auto natural = with_interval(*widest, minus_90deg_Hz);
  if (!natural || natural->half_width > kWorstShare * natural->value) return;
  if (natural->value > kFarthest * sheet.highest_Hz) return;
  sheet.natural_frequency_Hz = natural;
  sheet.damping_ratio = with_interval(*widest, [](const Eigen::Vector3d& p) -> std::optional<double> {
    if (!(p[0] > 0.0) || !(p[2] > 0.0)) return std::nullopt;
    return p[1] / (2.0 * std::sqrt(p[0] * p[2]));
  });
}

}  // namespace eha::ident
