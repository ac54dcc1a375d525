// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/margin_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/statistics/distributions.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::size_t kTones = MarginSweep::kHarmonics.size();
/// Phases of lowest peak among some thousand draws: 1.99 of the amplitude of a tone with weight 1.
constexpr std::array<double, kTones> kPhases_rad{0.8, 1.46, 5.63, 1.56, 0.11, 5.98};
constexpr std::array<double, kTones> kWeights{0.6, 1.0, 1.0, 0.7, 0.4, 0.2};  // of the speed
constexpr double kLowestTone = 0.4;                                           // of the crossover
constexpr double kSwept_s = 45.0;                                             // of all ways
constexpr std::size_t kMostWays = 12;
constexpr std::size_t kLeastWays = 4;
constexpr double kWaySpeed = 0.6;    // of the fastest reference
constexpr double kSweptSpeed = 0.8;  // of the way's speed: the valve stays open
// The least speed in smoothings of the inverse, each about two standard deviations of what the sensor's noise asks for.
// Nearer to it noise bends the command as a greater gain would.
constexpr double kClearOfSmoothing = 2.5;
constexpr double kLeastSweptSpeed = 0.3;  // of the way's speed
constexpr double kSweptSlew = 0.6;

/// Response of an integrating plant with the lag of the feed-forward.
Complex plant(const AxisSettings& s, double w) {
  return 1.0 / Complex(s.feed_forward.position_rate, w) * std::polar(1.0, -w * s.feed_forward.acceleration_s);
}

double crossover_rad_s(const AxisCoefficients& c) {
  const std::vector<double> grid = log_grid(0.05, std::numbers::pi / c.settings.tick_s, 400);
  double last = grid.front();
  for (const double w : grid) {
    if (std::abs(sampled_feedback(c, w) * plant(c.settings, w)) >= 1.0) last = w;
  }
  return last;
}

/// Returns the greatest absolute value over a period of the tones behind a response.
double peak(const MarginSweep& sweep, const std::array<Complex, kTones>& response) {
  constexpr int kPoints = 400;
  double most = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k < kTones; ++k) {
      const double angle = kTurn * MarginSweep::kHarmonics[k] * i / kPoints + sweep.phase_rad[k];
      sum += std::real(sweep.amplitude[k] * response[k] * std::polar(1.0, angle));
    }
    most = std::max(most, std::abs(sum));
  }
  return most;
}

/// Regression basis of the tones and a straight line over the measured rows of a way.
Eigen::MatrixXd tones_of(const MarginSweep& sweep) {
  const auto rows = static_cast<Eigen::Index>(sweep.measured_rows());
  Eigen::MatrixXd a(rows, 2 + 2 * static_cast<Eigen::Index>(kTones));
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(sweep.period_rows);
    a(i, 0) = 1.0;
    a(i, 1) = share - 0.5;
    for (std::size_t k = 0; k < kTones; ++k) {
      const double angle = kTurn * MarginSweep::kHarmonics[k] * share;
      a(i, 2 + 2 * static_cast<Eigen::Index>(k)) = std::cos(angle);
      a(i, 3 + 2 * static_cast<Eigen::Index>(k)) = std::sin(angle);
    }
  }
  return a;
}

/// Returns rod over injection at each tone, of one way.
std::array<Complex, kTones> response_of(const Eigen::MatrixXd& tones, const SweepWay& way) {
  const auto rows = static_cast<Eigen::Index>(way.rod.size());
  const Eigen::VectorXd injected = solve_full_rank(tones, Eigen::Map<const Eigen::VectorXd>(way.injected.data(), rows));
  const Eigen::VectorXd rod = solve_full_rank(tones, Eigen::Map<const Eigen::VectorXd>(way.rod.data(), rows));
  std::array<Complex, kTones> h;
  for (std::size_t k = 0; k < kTones; ++k) {
    const auto row = 2 + 2 * static_cast<Eigen::Index>(k);
    h[k] = Complex(rod[row], -rod[row + 1]) / Complex(injected[row], -injected[row + 1]);
  }
  return h;
}

std::vector<Complex> loop_of(const std::vector<std::array<Complex, kTones>>& ways, std::size_t left_out) {
  std::vector<Complex> loop(kTones);
  for (std::size_t k = 0; k < kTones; ++k) {
    Complex sum = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < ways.size(); ++i) {
      if (i == left_out) continue;
      sum += ways[i][k];
      count += 1.0;
    }
    const Complex h = sum / count;
    loop[k] = h / (1.0 - h);
  }
  return loop;
}

/// Fits a, -c, -b, d of the smooth loop through the tones, for frequencies over the highest tone.
Eigen::Vector4d smooth_through(const MarginSweep& sweep, const AxisCoefficients& c, const std::vector<double>& w,
                               const std::vector<Complex>& loop) {
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(2 * static_cast<Eigen::Index>(kTones), 4);
  Eigen::VectorXd b(a.rows());
  const double unit = 1.0 / w.back();
  for (std::size_t k = 0; k < kTones; ++k) {
    const Complex rest = std::log(loop[k] / (sampled_feedback(c, w[k]) * plant(c.settings, w[k])));
    const Complex h = loop[k] / (1.0 + loop[k]);
    const double weight = sweep.amplitude[k] * std::abs(h * (1.0 - h));
    const double x = w[k] * unit;
    const auto row = 2 * static_cast<Eigen::Index>(k);
    a(row, 0) = weight;
    a(row, 1) = weight * x * x;
    a(row + 1, 2) = weight * x;
    a(row + 1, 3) = weight * x * x * x;
    b[row] = weight * rest.real();
    b[row + 1] = weight * rest.imag();
  }
  return solve_pivoted(a, b);
}

/// Margins of the smooth loop `s`.
LoopMargins margins_of(const AxisCoefficients& c, const std::vector<double>& w, const Eigen::Vector4d& s) {
  constexpr int kPoints = 200;
  const double unit = 1.0 / w.back();
  const std::vector<double> grid = log_grid(w.front(), w.back(), kPoints);
  std::vector<Complex> smooth;
  for (const double at : grid) {
    const double x = at * unit;
    smooth.push_back(sampled_feedback(c, at) * plant(c.settings, at) *
                     std::exp(Complex(s[0] + s[1] * x * x, s[2] * x + s[3] * x * x * x)));
  }
  const double order =
      (c.settings.feed_forward.position_rate == 0.0 ? 1.0 : 0.0) + (c.settings.feedback.ki > 0.0 ? 1.0 : 0.0);
  return loop_margins(grid, smooth, order);
}

/// Returns the mean and its Student interval.
SweptValue mean_of(const std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  SweptValue mean;
  for (const double v : values) mean.value += v / count;
  double square = 0.0;
  for (const double v : values) square += (v - mean.value) * (v - mean.value);
  mean.half_width = student_exceeded(0.025, count - 1.0) * std::sqrt(square / (count - 1.0) / count);
  return mean;
}

}  // namespace

double MarginSweep::fundamental_rad_s() const noexcept { return kTurn / (tick_s * static_cast<double>(period_rows)); }

double MarginSweep::injected(std::size_t row) const noexcept {
  const double angle = kTurn * static_cast<double>(row % period_rows) / static_cast<double>(period_rows);
  double sum = 0.0;
  for (std::size_t k = 0; k < kHarmonics.size(); ++k) {
    sum += amplitude[k] * std::cos(angle * kHarmonics[k] + phase_rad[k]);
  }
  return sum;
}

MarginSweep margin_sweep(const AxisSettings& settings, double most_way, double most_error) {
  const AxisCoefficients c = coefficients(settings);
  const double h = settings.tick_s;
  const double crossover = crossover_rad_s(c);
  MarginSweep sweep;
  sweep.tick_s = h;
  // The highest tone stays below a third of the Nyquist frequency.
  const double fundamental =
      std::min(kLowestTone * crossover, std::numbers::pi / (3.0 * h * MarginSweep::kHarmonics.back()));
  sweep.period_rows = static_cast<std::size_t>(std::ceil(kTurn / fundamental / h));
  sweep.lead_rows = static_cast<std::size_t>(std::ceil(std::max(1.0, 6.0 / crossover) / h));
  const double way_s = h * static_cast<double>(sweep.way_rows());
  sweep.ways = std::clamp(2 * static_cast<std::size_t>(kSwept_s / way_s / 2.0), kLeastWays, kMostWays);
  sweep.speed = std::min(kWaySpeed * settings.reference.velocity, most_way / way_s);
  std::array<Complex, kTones> speed{};
  std::array<Complex, kTones> slew{};
  std::array<Complex, kTones> rod{};
  const double steepest = 1.0 / std::min(settings.inverse.gain_positive, settings.inverse.gain_negative);
  for (std::size_t k = 0; k < kTones; ++k) {
    const double w = sweep.fundamental_rad_s() * MarginSweep::kHarmonics[k];
    const Complex feedback = sampled_feedback(c, w);
    // The phases are those of the speed.
    const Complex g = plant(settings, w);
    speed[k] = feedback / (1.0 + feedback * g);
    slew[k] = steepest * Complex(0.0, w) * speed[k];
    rod[k] = g * speed[k];
    sweep.amplitude[k] = kWeights[k] / std::abs(speed[k]);
    sweep.phase_rad[k] = kPhases_rad[k] - std::arg(speed[k]);
  }
  const double swept = std::clamp(sweep.speed - kClearOfSmoothing * settings.inverse.smoothing,
                                  kLeastSweptSpeed * sweep.speed, kSweptSpeed * sweep.speed);
  const double scale = std::min({swept / peak(sweep, speed), kSweptSlew * settings.slew_per_s / peak(sweep, slew),
                                 most_error / peak(sweep, rod)});
  for (double& amplitude : sweep.amplitude) amplitude *= scale;
  return sweep;
}

MeasuredMargins measured_margins(const MarginSweep& sweep, const AxisSettings& settings,
                                 std::span<const SweepWay> ways) {
  const AxisCoefficients c = coefficients(settings);
  MeasuredMargins measured;
  for (const int harmonic : MarginSweep::kHarmonics) {
    measured.w_rad_s.push_back(sweep.fundamental_rad_s() * harmonic);
  }
  std::vector<std::array<Complex, kTones>> responses;
  const Eigen::MatrixXd tones = tones_of(sweep);
  for (const SweepWay& way : ways) responses.push_back(response_of(tones, way));
  measured.open_loop = loop_of(responses, responses.size());
  const Eigen::Vector4d whole = smooth_through(sweep, c, measured.w_rad_s, measured.open_loop);
  measured.margins = margins_of(c, measured.w_rad_s, whole);
  std::vector<double> gains;
  std::vector<double> lags_s;
  const auto count = static_cast<double>(responses.size());
  double phase = 0.0;
  double ms = 0.0;
  double mt = 0.0;
  double delay = 0.0;
  for (std::size_t i = 0; i < responses.size(); ++i) {
    // Pseudo-values of the jackknife: their mean is free of the logarithm's bias.
    const Eigen::Vector4d without = smooth_through(sweep, c, measured.w_rad_s, loop_of(responses, i));
    const Eigen::Vector4d s = count * whole - (count - 1.0) * without;
    gains.push_back(s[0]);
    lags_s.push_back(settings.feed_forward.acceleration_s - s[2] / measured.w_rad_s.back());
    const LoopMargins margins = margins_of(c, measured.w_rad_s, without);
    phase += std::pow(margins.phase_deg - measured.margins.phase_deg, 2);
    ms += std::pow(margins.ms - measured.margins.ms, 2);
    mt += std::pow(margins.mt - measured.margins.mt, 2);
    delay += std::pow(margins.delay_s - measured.margins.delay_s, 2);
  }
  measured.gain_share = mean_of(gains);
  measured.gain_share.value = std::exp(measured.gain_share.value);
  measured.gain_share.half_width *= measured.gain_share.value;
  measured.lag_s = mean_of(lags_s);
  const double factor = (count - 1.0) / count;
  measured.phase_std_deg = std::sqrt(factor * phase);
  measured.ms_std = std::sqrt(factor * ms);
  measured.mt_std = std::sqrt(factor * mt);
  measured.delay_std_s = std::sqrt(factor * delay);
  return measured;
}

}  // namespace eha::ident
