// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/importer/slow_rows.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <vector>

namespace eha::importer {
namespace {

using Eigen::Index;

constexpr Index kFewestShowing = 60;
/// Of a longer record the columns of all rows would take its memory tenfold: so many parts of so many rows show it.
constexpr Index kShownParts = 200;
constexpr Index kRowsOfShownPart = 1000;
constexpr double kByItsRow = 0.5;    // of the output's variance
constexpr double kByPastRows = 0.8;  // of it, at most
constexpr double kLeftBeside = 0.5;  // of what past rows leave over, with the row's own input
constexpr double kLeastLeft = 0.02;  // of the motions' variance, by past rows
constexpr double kByNext = 0.15;     // of that, by the input of the next row
constexpr double kTurned = 0.3;      // of its effect, that of the inputs before, the other way

/// Share of the variance of y that the columns explain beside a constant.
double share_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& y) {
  const Eigen::VectorXd left = y - columns * columns.colPivHouseholderQr().solve(y);
  return 1.0 - left.squaredNorm() / (y.array() - y.mean()).square().sum();
}

/// Rows of a record that stand for all: of a long one evenly spaced parts, in which no period of the input hides.
class Showing {
 public:
  explicit Showing(Index rows) {
    const bool is_long = rows > kShownParts * kRowsOfShownPart;
    const Index parts = is_long ? kShownParts : 1;
    const Index length = is_long ? kRowsOfShownPart : rows;
    rows_.reserve(static_cast<std::size_t>(parts * length));
    for (Index part = 0; part < parts; ++part) {
      const Index begin = parts == 1 ? 0 : part * (rows - length) / (parts - 1);
      for (Index row = begin; row < begin + length; ++row) rows_.push_back(row);
    }
  }

  [[nodiscard]] Index count() const { return static_cast<Index>(rows_.size()); }

  /// The values of those rows, `later` rows on.
  [[nodiscard]] Eigen::VectorXd of(const Eigen::VectorXd& values, Index later) const {
    return values.tail(values.size() - later)(rows_);
  }

 private:
  std::vector<Index> rows_;
};

}  // namespace

std::string remark_on_slow_rows(const Eigen::VectorXd& input, const Eigen::VectorXd& output, double step_s) {
  const Index n = output.size() - 2;
  if (n < kFewestShowing || input.size() != output.size() || !input.allFinite() || !output.allFinite()) return {};
  const Showing rows(n);
  const Eigen::VectorXd y = rows.of(output, 2);
  if (!(y.maxCoeff() > y.minCoeff()) || !(input.maxCoeff() > input.minCoeff())) return {};
  Eigen::MatrixXd columns(rows.count(), 6);
  columns << Eigen::VectorXd::Ones(rows.count()), rows.of(input, 1), rows.of(input, 0), rows.of(output, 1),
      rows.of(output, 0), rows.of(input, 2);
  const double by_past = share_of(columns.leftCols(5), y);
  if (by_past > kByPastRows) return {};
  Eigen::MatrixXd own(rows.count(), 2);
  own << columns.col(0), columns.col(5);
  const double by_own = share_of(own, y);
  const double by_all = share_of(columns, y);
  if (by_own < kByItsRow || 1.0 - by_all > kLeftBeside * (1.0 - by_past)) return {};
  return fmt::format(
      "the output answers within one row of {:.3g} s: the input of the same row explains {:.0f} % of it, all before "
      "only {:.0f} %; such rows are too slow to show how it answers: record at least ten times as many, or, where a "
      "logger shifts a column by a row, shift it back",
      step_s, 100.0 * by_own, 100.0 * by_past);
}

std::string motion_within_rows(const Eigen::VectorXd& input, const Eigen::VectorXd& output, double step_s) {
  const Index n = output.size() - 3;
  if (n < kFewestShowing || input.size() != output.size() || !input.allFinite() || !output.allFinite()) return {};
  const Eigen::VectorXd motions = output.tail(n + 2) - output.head(n + 2);
  const Showing rows(n);
  const Eigen::VectorXd motion = rows.of(motions, 2);
  if (!(motion.maxCoeff() > motion.minCoeff()) || !(input.maxCoeff() > input.minCoeff())) return {};
  Eigen::MatrixXd columns(rows.count(), 8);
  columns << Eigen::VectorXd::Ones(rows.count()), rows.of(input, 2), rows.of(input, 1), rows.of(input, 0),
      rows.of(motions, 1), rows.of(motions, 0), rows.of(output, 2), rows.of(input, 3);
  const double left = 1.0 - share_of(columns.leftCols(7), motion);
  const double by_next = left - (1.0 - share_of(columns, motion));
  if (left < kLeastLeft || by_next < kByNext * left) return {};
  // A controller that makes the input from the output turns the sign.
  const Eigen::VectorXd found = columns.colPivHouseholderQr().solve(motion);
  if (found[7] * (found[1] + found[2] + found[3]) < -kTurned * found[7] * found[7]) return {};
  return fmt::format(
      "the output answers within one row of {:.3g} s: of the motion that all rows before leave open the input of the "
      "next row explains {:.0f} %, as where the input moves between the rows; such rows are too slow to show how the "
      "output answers: record at least ten times as many, or, where a logger shifts a column by a row, shift it back",
      step_s, 100.0 * by_next / left);
}

}  // namespace eha::importer
