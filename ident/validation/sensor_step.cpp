// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/sensor_step.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace eha::ident {
namespace {

constexpr Eigen::Index kShortestStay = 8;
constexpr std::size_t kMostStays = 64;
constexpr std::size_t kMostOfStays = std::size_t{1} << 23U;  // numbers of all columns together, 64 MiB
constexpr double kVariances = 12.0;                          // of rounding, in a squared step
constexpr double kAlike = 0.5;  // of a stay: neighbours at least so long belong to one slow way

struct RoundedStay {
  Eigen::Index first = 0;
  Eigen::Index rows = 0;
};

/// Where the output stays at a value, in their order. One reading beside it, as noise makes, does not end a stay.
std::vector<RoundedStay> stays_of(const Eigen::VectorXd& output, double step) {
  std::vector<RoundedStay> found;
  const double near = 0.5 * step;
  for (Eigen::Index k = 0; k < output.size();) {
    Eigen::Index end = k + 1;
    Eigen::Index last = k;
    while (end < output.size() && end - last <= 2) {
      if (std::abs(output[end] - output[k]) < near) last = end;
      ++end;
    }
    found.push_back({k, last - k + 1});
    k = last + 1;
  }
  return found;
}

/// A stay on a slow way: the output goes through the whole step, and its errors cancel.
bool is_passed(const std::vector<RoundedStay>& stays, std::size_t at, const Eigen::VectorXd& output, double step) {
  if (at == 0 || at + 1 == stays.size()) return false;
  const RoundedStay& before = stays[at - 1];
  const RoundedStay& after = stays[at + 1];
  const double come = (output[stays[at].first] - output[before.first]) / step;
  const double go = (output[after.first] - output[stays[at].first]) / step;
  return come * go > 0.0 && std::abs(come) < 1.5 && std::abs(go) < 1.5 &&
         kAlike * static_cast<double>(stays[at].rows) <= static_cast<double>(std::min(before.rows, after.rows));
}

/// Standard deviation of a resting signal's noise in steps, by how often successive rows differ and turn back.
/// Of white noise below a third of a step they differ in a share of 2 / sqrt(pi) of it.
double noise_in_steps(const Eigen::VectorXd& output, double step) {
  Eigen::Index looked_at = 0;
  Eigen::Index turns = 0;
  double change = 0.0;  // the last one
  Eigen::Index changed = -kShortestStay;
  for (Eigen::Index k = 1; k < output.size(); ++k) {
    const double now = std::round((output[k] - output[k - 1]) / step);
    if (std::abs(now) > 1.0) continue;
    ++looked_at;
    if (now == 0.0) continue;
    if (now * change < 0.0 && k - changed < kShortestStay) ++turns;
    change = now;
    changed = k;
  }
  return looked_at > 0 ? 0.5 * std::sqrt(std::numbers::pi) * static_cast<double>(turns) / static_cast<double>(looked_at)
                       : 0.0;
}

/// Standard deviation of the error of rounding a resting signal. Noise before the rounding takes its mean away: the
/// first harmonic of the error over the place between two steps by exp(-2 pi^2 s^2), s in steps (B. Widrow and I.
/// Kollar, Quantization Noise, 2008, on dither).
double error_at_rest(const Eigen::VectorXd& output, double step) {
  const double s = noise_in_steps(output, step);
  return step / std::sqrt(kVariances) * std::exp(-2.0 * std::numbers::pi * std::numbers::pi * s * s);
}

}  // namespace

std::optional<SensorStep> sensor_step(double step, const Eigen::VectorXd& output, int every,
                                      const Eigen::VectorXd& residual) {
  if (!(step > 0.0) || residual.size() == 0) return std::nullopt;
  const double power = residual.squaredNorm() / static_cast<double>(residual.size());
  // What noise makes of the rounding is noise from row to row, which the mean over rows averages.
  const double at_rest = error_at_rest(output, step);
  const double rounded = step * step / kVariances;
  const double kept = at_rest * at_rest + (rounded - at_rest * at_rest) / std::max(1, every);
  return kept >= kShownByRounding * power ? std::optional(SensorStep{step}) : std::nullopt;
}

Eigen::MatrixXd rounded_stays(const Record& record, double step, const Comparison& comparison, Eigen::Index first) {
  const Eigen::Index rows = static_cast<Eigen::Index>(comparison.count) - first;
  if (!(step > 0.0) || rows < 1) return Eigen::MatrixXd(std::max<Eigen::Index>(rows, 0), 0);
  const std::vector<RoundedStay> all = stays_of(record.output, step);
  std::vector<RoundedStay> stays;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (all[k].rows >= kShortestStay && !is_passed(all, k, record.output, step)) stays.push_back(all[k]);
  }
  std::stable_sort(stays.begin(), stays.end(), [](const auto& a, const auto& b) { return a.rows > b.rows; });
  const std::size_t most = std::clamp<std::size_t>(kMostOfStays / static_cast<std::size_t>(rows), 1, kMostStays);
  if (stays.size() > most) stays.resize(most);
  const double rms = error_at_rest(record.output, step);
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(stays.size()));
  Eigen::Index next = 0;
  for (const RoundedStay& stay : stays) {
    Eigen::VectorXd error = Eigen::VectorXd::Zero(record.output.size());
    error.segment(stay.first, stay.rows).setConstant(rms);
    const Eigen::VectorXd column = picked(error, comparison).tail(rows);
    if (column.cwiseAbs().maxCoeff() > 0.0) columns.col(next++) = column;
  }
  columns.conservativeResize(Eigen::NoChange, next);
  return columns;
}

}  // namespace eha::ident
