// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/nonlinear_effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "ident/fractional/stability.hpp"
#include "ident/model/model_output.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/held_levels.hpp"

namespace eha::ident {
namespace {

constexpr double kChange = 1e-6;  // of the range: less is rounding
constexpr std::array<Eigen::Index, 3> kOutputLags = {0, 1, 3};
constexpr Eigen::Index kMostWholeRows = 1'000'000;
constexpr Eigen::Index kFewerRows = 500'000;  // of a longer record
constexpr Eigen::Index kFewestBlocks = 4;     // a compared row

Eigen::VectorXd about_mean(Eigen::VectorXd signal) {
  signal.array() -= signal.mean();
  return signal;
}

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
/// @param input  of the record, without its noise
Eigen::VectorXd output_of_every_row(const Model& model, const Record& record, const Eigen::VectorXd& input) {
  const Eigen::Index rows = input.size();
  if (rows <= kMostWholeRows || model.grey_box) return simulate(model, input, record.step_s);
  const auto every = static_cast<std::size_t>(1 + (rows - 1) / kFewerRows);
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

/// Rows of a long record that are averaged before a response of compared rows is computed; 1 for others.
Eigen::Index averaged_rows(Eigen::Index rows, std::size_t every) {
  const auto compared = static_cast<Eigen::Index>(every);
  Eigen::Index most = 1;
  for (Eigen::Index block = 2; kFewestBlocks * block <= compared; ++block) {
    if (compared % block == 0) most = block;
  }
  return rows > kMostWholeRows ? most : 1;
}

/// Responses of the model's G at the compared rows. The signals of a long record are averaged over blocks first: what
/// they lose lies far above the Nyquist frequency of the compared rows.
class Responses {
 public:
  Responses(const Model& model, OutputOnRecord& outputs)
      : model_(model), outputs_(outputs), block_(averaged_rows(outputs.record().input.size(), of(outputs).every)) {
    if (block_ == 1) return;
    const auto parts = static_cast<std::size_t>(block_);
    const std::size_t every = of(outputs).every / parts;
    averaged_.step_s = outputs.record().step_s * static_cast<double>(block_);
    averaged_.input.resize(outputs.record().input.size() / block_);
    // Compared rows are multiples of `every`, so each begins a block.
    comparison_ = {of(outputs).first / parts, every, of(outputs).count, antialias_taps(every)};
    of_blocks_.emplace(averaged_, comparison_);
  }
  Responses(const Responses&) = delete;
  Responses& operator=(const Responses&) = delete;

  [[nodiscard]] Eigen::VectorXd to(const Eigen::VectorXd& signal) {
    if (!of_blocks_) return outputs_.response(model_.transfer_function, about_mean(signal));
    const Eigen::Index blocks = signal.size() / block_;
    Eigen::VectorXd means = signal.head(blocks * block_).reshaped(block_, blocks).colwise().mean().transpose();
    return of_blocks_->response(model_.transfer_function, about_mean(std::move(means)));
  }

 private:
  static const Comparison& of(const OutputOnRecord& outputs) { return outputs.comparison(); }

  const Model& model_;
  OutputOnRecord& outputs_;
  Eigen::Index block_;
  Record averaged_;  ///< its length and step alone
  Comparison comparison_;
  std::optional<OutputOnRecord> of_blocks_;
};

/// Collects columns at the compared rows.
class Columns {
 public:
  Columns(const Model& model, OutputOnRecord& outputs, Eigen::Index first)
      : outputs_(outputs), responses_(model, outputs), first_(first) {}

  /// The signal's rows, each delayed by a lag.
  template <typename Lags>
  void add(const Eigen::VectorXd& signal, const Lags& lags) {
    const Eigen::VectorXd compared = picked(signal, outputs_.comparison());
    const Eigen::Index rows = compared.size() - first_;
    for (const Eigen::Index lag : lags) push(compared.segment(first_ - lag, rows));
  }
  /// Returns the response of the model's G to the signal.
  void add_through_plant(const Eigen::VectorXd& signal) {
    const Eigen::VectorXd output = responses_.to(signal);
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

  OutputOnRecord& outputs_;
  Responses responses_;
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
      return "position";
    case NonlinearKind::time:
      break;
  }
  return "time";
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
  // Noise of the input's channel did not reach the plant; kept, an effect of it would stand for the noise itself.
  const std::optional<Eigen::VectorXd> levels = held_levels(record.input);
  const Eigen::VectorXd& input = levels ? *levels : record.input;
  const Eigen::VectorXd behind_map = model.input_map ? mapped(*model.input_map, input) : Eigen::VectorXd();
  const Eigen::VectorXd& driving = model.input_map ? behind_map : input;
  const auto v = driving.array() - driving.mean();
  Columns columns(model, outputs, static_cast<Eigen::Index>(first));
  const Eigen::Index lag = least_input_lag(outputs.comparison());
  const std::array<Eigen::Index, 3> input_lags = {lag, lag + 1, lag + 2};
  std::vector<NonlinearEffects> all;
  // One signal after the other: each may have 10^7 rows.
  const auto add_input = [&](const Eigen::VectorXd& signal) {
    columns.add_through_plant(signal);
    columns.add(signal, input_lags);
  };
  add_input(v.abs());
  add_input(v * v.abs());
  add_input(v.cube());
  all.push_back(columns.taken(NonlinearKind::level));
  add_input(direction(v));
  all.push_back(columns.taken(NonlinearKind::direction));
  const Eigen::VectorXd y = about_mean(output_of_every_row(model, record, input));
  columns.add(direction(y), kOutputLags);
  all.push_back(columns.taken(NonlinearKind::motion));
  columns.add_through_plant(v * y.array());
  columns.add(y.array().square().matrix(), kOutputLags);
  columns.add(y.array().cube().matrix(), kOutputLags);
  all.push_back(columns.taken(NonlinearKind::position));
  const Eigen::ArrayXd time = Eigen::ArrayXd::LinSpaced(driving.size(), -1.0, 1.0);
  columns.add_through_plant(v * time);
  columns.add_through_plant(v * time.square());
  all.push_back(columns.taken(NonlinearKind::time));
  return all;
}

}  // namespace eha::ident
