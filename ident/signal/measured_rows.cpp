// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/signal/measured_rows.hpp"

#include <algorithm>
#include <utility>

namespace eha::ident {
namespace {

constexpr double kMostOfEnergy = 0.25;  // of a filter's taps, on rows that were not measured

}  // namespace

MeasuredRows::MeasuredRows(const Record& record, const Comparison& comparison) {
  if (record.unmeasured.empty() || comparison.count == 0) return;
  const auto first = static_cast<Eigen::Index>(comparison.first);
  const auto every = static_cast<Eigen::Index>(comparison.every);
  const auto count = static_cast<Eigen::Index>(comparison.count);
  const auto half = static_cast<Eigen::Index>(comparison.taps.size() / 2);
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(count);
  double whole = comparison.taps.empty() ? 1.0 : 0.0;
  for (const double tap : comparison.taps) whole += tap * tap;
  for (const std::size_t unmeasured : record.unmeasured) {
    // The compared rows whose windows hold it.
    const Eigen::Index place = static_cast<Eigen::Index>(unmeasured) - first;
    const Eigen::Index from = std::max<Eigen::Index>(0, (place - half + every - 1) / every);
    for (Eigen::Index row = from; row < count && row * every <= place + half; ++row) {
      const Eigen::Index tap = place - row * every + half;
      if (tap < 0 || tap > 2 * half) continue;
      energy[row] += comparison.taps.empty() ? 1.0
                                             : comparison.taps[static_cast<std::size_t>(tap)] *
                                                   comparison.taps[static_cast<std::size_t>(tap)];
    }
  }
  for (Eigen::Index row = 0; row < count; ++row) {
    if (energy[row] > kMostOfEnergy * whole) left_out_.push_back(row);
  }
}

MeasuredRows MeasuredRows::from(Eigen::Index first) const {
  MeasuredRows rest;
  for (const Eigen::Index row : left_out_) {
    if (row >= first) rest.left_out_.push_back(row - first);
  }
  return rest;
}

Eigen::Index MeasuredRows::count(Eigen::Index rows) const {
  return rows - (std::lower_bound(left_out_.begin(), left_out_.end(), rows) - left_out_.begin());
}

std::vector<Eigen::Index> MeasuredRows::kept(Eigen::Index rows) const {
  std::vector<Eigen::Index> all;
  all.reserve(static_cast<std::size_t>(rows));
  auto next = left_out_.begin();
  for (Eigen::Index row = 0; row < rows; ++row) {
    if (next != left_out_.end() && *next == row) {
      ++next;
    } else {
      all.push_back(row);
    }
  }
  return all;
}

Eigen::VectorXd MeasuredRows::of(Eigen::VectorXd values) const {
  if (are_all()) return values;
  return values(kept(values.size()));
}

Eigen::MatrixXd MeasuredRows::of_columns(Eigen::MatrixXd columns) const {
  if (are_all()) return columns;
  return columns(kept(columns.rows()), Eigen::all);
}

Eigen::VectorXd MeasuredRows::weights(Eigen::Index rows) const {
  if (are_all()) return {};
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(rows);
  for (const Eigen::Index row : left_out_) {
    if (row < rows) weights[row] = 0.0;
  }
  return weights;
}

Unmeasured unmeasured_of(const Record& record) { return unmeasured_of(record, record.unmeasured); }

Unmeasured unmeasured_of(const Record& record, const std::vector<std::size_t>& without_input) {
  const std::vector<std::size_t>& rows = without_input;
  Unmeasured found{.rows = record.unmeasured.size(),
                   .without_input = rows.size(),
                   .of_rows = std::max<std::size_t>(1, static_cast<std::size_t>(record.output.size()))};
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i + 1;
    while (end < rows.size() && rows[end] == rows[end - 1] + 1) ++end;
    if (end - i >= kRowsOfGap) found.in_gaps += end - i;
    i = end;
  }
  return found;
}

std::vector<std::size_t> rows_within(const std::vector<std::size_t>& rows, std::size_t first, std::size_t count) {
  std::vector<std::size_t> within;
  for (const std::size_t row : rows) {
    if (row >= first && row - first < count) within.push_back(row - first);
  }
  return within;
}

}  // namespace eha::ident
