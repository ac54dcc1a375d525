// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/sensor_step.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ident/signal/value_step.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kShortestStay = 8;
constexpr std::size_t kMostStays = 64;
constexpr double kVariances = 12.0;  // of rounding, in a squared step

struct RoundedStay {
  Eigen::Index first = 0;
  Eigen::Index rows = 0;
};

double step_of(const Record& record) {
  return value_step({record.output.data(), static_cast<std::size_t>(record.output.size())});
}

/// Where the output stays at a value, the longest first. One reading beside it, as noise makes, does not end a stay.
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
    if (last - k + 1 >= kShortestStay) found.push_back({k, last - k + 1});
    k = last + 1;
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const RoundedStay& a, const RoundedStay& b) { return a.rows > b.rows; });
  if (found.size() > kMostStays) found.resize(kMostStays);
  return found;
}

}  // namespace

std::optional<SensorStep> sensor_step(const Record& record, const Eigen::VectorXd& residual) {
  const double step = residual.size() > 0 ? step_of(record) : 0.0;
  const double power = residual.size() > 0 ? residual.squaredNorm() / static_cast<double>(residual.size()) : 0.0;
  if (!(step > 0.0) || !(step * step / kVariances >= kShownByRounding * power)) return std::nullopt;
  return SensorStep{step};
}

Eigen::MatrixXd rounded_stays(const Record& record, const Comparison& comparison, Eigen::Index first) {
  const Eigen::Index rows = static_cast<Eigen::Index>(comparison.count) - first;
  const double step = step_of(record);
  if (!(step > 0.0) || rows < 1) return Eigen::MatrixXd(std::max<Eigen::Index>(rows, 0), 0);
  const std::vector<RoundedStay> stays = stays_of(record.output, step);
  Eigen::MatrixXd columns(rows, static_cast<Eigen::Index>(stays.size()));
  Eigen::Index next = 0;
  for (const RoundedStay& stay : stays) {
    Eigen::VectorXd error = Eigen::VectorXd::Zero(record.output.size());
    error.segment(stay.first, stay.rows).setConstant(step / std::sqrt(kVariances));
    const Eigen::VectorXd column = picked(error, comparison).tail(rows);
    if (column.cwiseAbs().maxCoeff() > 0.0) columns.col(next++) = column;
  }
  columns.conservativeResize(Eigen::NoChange, next);
  return columns;
}

}  // namespace eha::ident
