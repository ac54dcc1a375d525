// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/track/seen_valve.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "config/valve_estimate.hpp"

namespace eha::track {
namespace {

constexpr double kSpeed_s = 0.1;  // rows over which speeds are differences
constexpr double kMoving_in_per_s = 0.03;
constexpr Eigen::Index kFewestRowsAWay = 5;  // in motion
constexpr double kChangeShare = 0.07;        // of a gain
constexpr double kLeastStd_V = 1e-3;
constexpr double kClear = 4.0;        // standard deviations; neighbouring rows of a motion are alike
constexpr double kMinor = 1.0 / 3.0;  // of the greater change

}  // namespace

std::size_t mean_width(double tick_s) {
  return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(kMean_s / tick_s)));
}

std::vector<double> means(const std::vector<double>& values, std::size_t width) {
  std::vector<double> sums(values.size() + 1, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sums[i + 1] = sums[i] + values[i];
  std::vector<double> result(values.size());
  const std::size_t half = width / 2;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t reach = std::min({half, i, values.size() - 1 - i});
    result[i] = (sums[i + reach + 1] - sums[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return result;
}

SeenValve seen_valve(const std::vector<double>& command_V, const std::vector<double>& rod, double tick_s) {
  const auto reach = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.5 * kSpeed_s / tick_s)));
  const std::vector<double> volts = means(command_V, 2 * reach);
  const double span_s = 2.0 * static_cast<double>(reach) * tick_s;
  std::vector<std::array<double, 6>> used;
  for (std::size_t i = 2 * reach; i + 2 * reach < rod.size(); i += reach) {
    const double v = (rod[i + reach] - rod[i - reach]) / span_s;
    const double before = (rod[i] - rod[i - 2 * reach]) / span_s;
    const double after = (rod[i + 2 * reach] - rod[i]) / span_s;
    if (std::min({std::abs(v), std::abs(before), std::abs(after)}) < kMoving_in_per_s || before * after < 0.0) continue;
    used.push_back(
        {1.0, v > 0.0 ? 1.0 : -1.0, std::max(v, 0.0), std::min(v, 0.0), (after - before) / span_s, volts[i]});
  }
  Eigen::MatrixXd a(static_cast<Eigen::Index>(used.size()), 5);
  Eigen::VectorXd u(a.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto& row = used[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < 5; ++j) a(i, j) = row[static_cast<std::size_t>(j)];
    u[i] = row[5];
  }
  // A trial that ended early moved one way alone, or not at all: that tells no gain of the other.
  const auto both_ways = std::min((a.col(2).array() > 0.0).count(), (a.col(3).array() < 0.0).count());
  if (both_ways < kFewestRowsAWay) return {};
  const Eigen::VectorXd x = a.colPivHouseholderQr().solve(u);
  const double rest = (u - a * x).squaredNorm() / static_cast<double>(std::max<Eigen::Index>(1, a.rows() - a.cols()));
  const Eigen::MatrixXd covariance = rest * (a.transpose() * a).inverse();
  return {x[0],
          x[1],
          1.0 / x[2],
          1.0 / x[3],
          std::sqrt(covariance(0, 0)),
          std::sqrt(covariance(1, 1)),
          std::sqrt(covariance(2, 2)) / x[2],
          std::sqrt(covariance(3, 3)) / x[3]};
}

std::vector<std::string> changes_of(const SeenValve& seen, const ident::InverseMap& map, const DisplayUnit& unit) {
  std::vector<std::string> changes;
  struct Volts {
    const char* name;
    double was;
    double is;
    double std;
    [[nodiscard]] bool differs() const { return std::abs(is - was) > config::kSameValve_V && far() >= kClear; }
    [[nodiscard]] double far() const { return std::abs(is - was) / std::max(std, kLeastStd_V); }
  };
  const auto gain = [&](const char* name, double was, double is, double std) {
    if (std::abs(is / was - 1.0) > std::max(kChangeShare, kClear * std)) {
      const double factor = unit.factor(kGainUnit);
      changes.push_back(fmt::format("{} {:.4g} {} instead of {:.4g}, {:+.0f} %", name, factor * is, unit.of(kGainUnit),
                                    factor * was, 100.0 * (is / was - 1.0)));
    }
  };
  if (!(seen.gain_positive_in_per_V_s > 0.0 && seen.gain_negative_in_per_V_s > 0.0)) return changes;
  std::array<Volts, 2> both{Volts{"null", map.null, seen.null_V, seen.null_std_V},
                            Volts{"half dead band", map.dead_band, seen.dead_band_V, seen.dead_band_std_V}};
  if (both[1].far() > both[0].far()) std::swap(both[0], both[1]);
  for (const Volts& one : both) {
    if (!one.differs() || (both[0].differs() && one.far() < kMinor * both[0].far())) continue;
    changes.push_back(fmt::format("{} {:.3f} V instead of {:.3f} V", one.name, one.is, one.was));
  }
  gain("gain extending", map.gain_positive, seen.gain_positive_in_per_V_s, seen.gain_positive_std);
  gain("gain retracting", map.gain_negative, seen.gain_negative_in_per_V_s, seen.gain_negative_std);
  return changes;
}

}  // namespace eha::track
