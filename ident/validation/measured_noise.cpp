// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/measured_noise.hpp"

#include <cmath>

#include "ident/signal/decimation.hpp"

namespace eha::ident {

namespace {

constexpr std::size_t kFewest = 2;

/// Without the period in which the plant leaves its rest: its transient differs from the other periods, yet is no
/// noise.
Periods settled(Periods periods) {
  if (periods.count <= kFewest || periods.first >= periods.length) return periods;
  periods.first += periods.length;
  --periods.count;
  return periods;
}

}  // namespace

double measured_noise(const Eigen::Ref<const Eigen::VectorXd>& output, const Periods& all, int decimation) {
  const Periods periods = settled(all);
  const PeriodicSignal signal = average_periods(output, periods, Drift::remove);
  // The mean period has absorbed a share of the noise.
  const auto count = static_cast<double>(periods.count);
  const Eigen::MatrixXd spread = (signal.periods.colwise() - signal.mean) * std::sqrt(count / (count - 1.0));
  const Eigen::VectorXd rows = spread.reshaped();
  const Comparison comparison =
      compare_every(static_cast<std::size_t>(rows.size()), static_cast<std::size_t>(decimation), 0);
  if (comparison.count < 2) return 0.0;
  return std::sqrt(picked(rows, comparison).squaredNorm() / static_cast<double>(comparison.count));
}

}  // namespace eha::ident
