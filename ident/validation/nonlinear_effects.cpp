// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/nonlinear_effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "ident/fractional/stability.hpp"
#include "ident/model/model_output.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {
namespace {

constexpr double kChange = 1e-6;  // of the range: less is rounding
constexpr std::array<Eigen::Index, 3> kOutputLags = {0, 1, 3};
constexpr Eigen::Index kMostWholeRows = 1'000'000;

Eigen::VectorXd about_mean(const Eigen::VectorXd& signal) { return signal.array() - signal.mean(); }

/// Returns the sign of the last change of a signal beyond rounding; 0 before the first such change.
Eigen::VectorXd direction(const Eigen::VectorXd& signal) {
  const double least = kChange * (signal.maxCoeff() - signal.minCoeff());
  Eigen::VectorXd sign = Eigen::VectorXd::Zero(signal.size());
  double held = signal[0];
  double now = 0.0;
  for (Eigen::Index k = 0; k < signal.size(); ++k) {
    if (std::abs(signal[k] - held) > least) {
      now = signal[k] > held ? 1.0 : -1.0;
      held = signal[k];
    }
    sign[k] = now;
  }
  return sign;
}

/// The model's output at every row. A longer record has it filtered at fewer rows and straight lines between them, for
/// the tables of all of its rows would take 200 bytes a row.
Eigen::VectorXd output_of_every_row(const Model& model, const Record& record) {
  const Eigen::Index rows = record.input.size();
  const auto every = static_cast<std::size_t>(1 + (rows - 1) / kMostWholeRows);
  if (every == 1 || model.grey_box) return simulate(model, record.input, record.step_s);
  const Comparison comparison = compare_every(static_cast<std::size_t>(rows), every, 0);
  OutputOnRecord fewer(record, comparison);
  const Eigen::VectorXd at = fewer.of(model).total(model);
  const auto first = static_cast<double>(comparison.first);
  const auto last = static_cast<double>(at.size() - 1);
  Eigen::VectorXd y(rows);
  for (Eigen::Index n = 0; n < rows; ++n) {
    const double place = std::clamp((static_cast<double>(n) - first) / static_cast<double>(every), 0.0, last);
    const auto before = std::min(static_cast<Eigen::Index>(place), at.size() - 2);
    const double share = place - static_cast<double>(before);
    y[n] = (1.0 - share) * at[before] + share * at[before + 1];
  }
  return y;
}

/// Collects columns at the compared rows.
class Columns {
 public:
  Columns(const Model& model, OutputOnRecord& outputs, Eigen::Index first)
      : model_(model), outputs_(outputs), first_(first) {}

  /// The signal's rows, each delayed by a lag.
  template <typename Lags>
  void add(const Eigen::VectorXd& signal, const Lags& lags) {
    const Eigen::VectorXd compared = picked(signal, outputs_.comparison());
    const Eigen::Index rows = compared.size() - first_;
    for (const Eigen::Index lag : lags) push(compared.segment(first_ - lag, rows));
  }
  /// Returns the response of the model's G to the signal.
  void add_through_plant(const Eigen::VectorXd& signal) {
    const Eigen::VectorXd output = outputs_.response(model_.transfer_function, about_mean(signal));
    push(output.tail(output.size() - first_));
  }
  [[nodiscard]] NonlinearEffects taken(NonlinearKind kind) {
    NonlinearEffects effects{kind, std::move(columns_)};
    columns_.resize(0, 0);
    return effects;
  }

 private:
  void push(const Eigen::VectorXd& column) {
    columns_.conservativeResize(column.size(), columns_.cols() + 1);
    columns_.rightCols(1) = column;
  }

  const Model& model_;
  OutputOnRecord& outputs_;
  Eigen::Index first_;
  Eigen::MatrixXd columns_;
};

}  // namespace

std::string_view text(NonlinearKind kind) {
  switch (kind) {
    case NonlinearKind::level:
      return "level";
    case NonlinearKind::direction:
      return "direction";
    case NonlinearKind::motion:
      return "motion";
    case NonlinearKind::position:
      break;
  }
  return "position";
}

std::string_view text(GainTrend trend) {
  switch (trend) {
    case GainTrend::falls:
      return "falls";
    case GainTrend::grows:
      return "grows";
    case GainTrend::unknown:
      break;
  }
  return "";
}

std::vector<NonlinearEffects> nonlinear_effects(const Model& model, OutputOnRecord& outputs, std::size_t first) {
  if (grows(model.transfer_function)) return {};
  const Record& record = outputs.record();
  const Eigen::VectorXd v = about_mean(model.input_map ? mapped(*model.input_map, record.input) : record.input);
  Columns columns(model, outputs, static_cast<Eigen::Index>(first));
  const Eigen::Index lag = least_input_lag(outputs.comparison());
  const std::array<Eigen::Index, 3> input_lags = {lag, lag + 1, lag + 2};
  std::vector<NonlinearEffects> all;
  // One signal after the other: each may have 10^7 rows.
  const auto add_input = [&](const Eigen::VectorXd& signal) {
    columns.add_through_plant(signal);
    columns.add(signal, input_lags);
  };
  add_input(v.cwiseAbs());
  add_input(v.cwiseProduct(v.cwiseAbs()));
  add_input(v.array().cube());
  all.push_back(columns.taken(NonlinearKind::level));
  add_input(direction(v));
  all.push_back(columns.taken(NonlinearKind::direction));
  const Eigen::VectorXd y = about_mean(output_of_every_row(model, record));
  columns.add(direction(y), kOutputLags);
  all.push_back(columns.taken(NonlinearKind::motion));
  columns.add_through_plant(v.cwiseProduct(y));
  columns.add(y.array().square().matrix(), kOutputLags);
  columns.add(y.array().cube().matrix(), kOutputLags);
  all.push_back(columns.taken(NonlinearKind::position));
  return all;
}

}  // namespace eha::ident
