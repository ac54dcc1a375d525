// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/record_part_remarks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "ident/model/parameter_text.hpp"
#include "ident/uncertainty/usable_band.hpp"

namespace eha::identify {
namespace {

constexpr double kFewestPeriods = 2.0;
constexpr double kEnoughPeriods = 10.0;

/// Whether an input moves one way alone, as a step and a ramp do, noise aside.
bool moves_once(const Eigen::VectorXd& input) {
  constexpr Eigen::Index kParts = 40;
  constexpr double kWayOverRange = 1.2;
  const Eigen::Index rows = input.size() / kParts;
  if (rows < 1) return false;
  double way = 0.0;
  Eigen::VectorXd means(kParts);
  for (Eigen::Index i = 0; i < kParts; ++i) {
    means[i] = input.segment(i * rows, rows).mean();
    if (i > 0) way += std::abs(means[i] - means[i - 1]);
  }
  return way < kWayOverRange * std::abs(means[kParts - 1] - means[0]);
}

/// "0.63 periods", "1 period"
std::string periods_text(double periods) {
  const std::string count = fmt::format("{:.2g}", periods);
  return count + (count == "1" ? " period" : " periods");
}

}  // namespace

std::optional<PieceRemark> piece_remark(const IdentificationTask& task) {
  const double step_s = task.record.step_s;
  const auto rows = static_cast<double>(task.record.input.size()) - std::max(0.0, task.options.discard_s) / step_s;
  const auto estimating = static_cast<Eigen::Index>(rows * std::min(1.0, task.options.split));
  if (estimating < 1 || estimating > task.record.input.size()) return {};
  const auto first = static_cast<Eigen::Index>(static_cast<double>(task.record.input.size()) - rows);
  const auto moves = ident::excited_band(task.record.input.segment(first, estimating), step_s);
  if (!moves) return {};
  const double estimating_s = static_cast<double>(estimating) * step_s;
  // The tones of an experiment are known, however small the fast ones are.
  const double periods = estimating_s * (task.excited ? *task.excited : *moves).highest_Hz;
  if (periods >= kFewestPeriods) return {};
  if (const Eigen::VectorXd& input = task.record.input; moves_once(input)) {
    return PieceRemark{fmt::format(
        "the input moves once, from {:.3g} to {:.3g}{}: other models may follow one motion as well, with another gain, "
        "and a longer record of it tells no more: play several steps up and down, or a multisine",
        input[0], input[input.size() - 1], ident::after_number(task.record.input_channel.unit))};
  }
  const double enough_s = rows * step_s * kEnoughPeriods / periods;
  std::string sentence = fmt::format(
      "the record is short: the {:.3g} s that estimate a model hold {} of the input's fastest motion, and no whole one "
      "of what is slower; other models may follow it as well, with another gain; record {:.3g} s or more",
      estimating_s, periods_text(periods), enough_s);
  return PieceRemark{std::move(sentence), ident::RecordFacts::Piece{rows * step_s, enough_s}};
}

std::string other_split_remark(const ident::CoveringSplit& other, const IdentificationTask& task) {
  const std::string unit = ident::after_number(task.record.input_channel.unit);
  const std::string first = fmt::format("{:.4g} to {:.4g}{}", other.lowest, other.highest, unit);
  const std::string rest = fmt::format("{:.4g} to {:.4g}{}", other.lowest_of_rest, other.highest_of_rest, unit);
  // Of one range the first part has too few levels on one side of the input's middle.
  const std::string what =
      first == rest ? fmt::format(
                          "both parts of the record have an input of {}, but the first too few of its levels, "
                          "so that it does not tell a valve's dead band and gains",
                          first)
                    : fmt::format(
                          "the two parts of the record see different inputs, {} and {}, and the first does not "
                          "tell a valve's dead band and gains",
                          first, rest);
  return fmt::format(
      "{}; so {:.0f} % of the record estimate and the rest judges; with --split {:g} as by default, or 1 for all of it",
      what, 100.0 * other.share, task.options.split);
}

}  // namespace eha::identify
