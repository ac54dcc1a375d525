// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

/// The compared rows of a record that were measured. The others count nowhere: neither in a cost nor in its
/// derivatives, scores and tests. An interpolated output would agree with any smooth model.
class MeasuredRows {
 public:
  MeasuredRows() = default;  ///< all rows
  /// Behind a filter a row counts as measured unless more than a quarter of the energy of its taps falls on rows that
  /// were not. Cost O(unmeasured taps / every).
  MeasuredRows(const Record& record, const Comparison& comparison);

  [[nodiscard]] bool are_all() const noexcept { return left_out_.empty(); }
  /// The same rows, counted from row `first` on.
  [[nodiscard]] MeasuredRows from(Eigen::Index first) const;
  /// How many of the first `rows` rows were measured.
  [[nodiscard]] Eigen::Index count(Eigen::Index rows) const;
  /// The measured ones of the values at the first rows.
  [[nodiscard]] Eigen::VectorXd of(Eigen::VectorXd values) const;
  [[nodiscard]] Eigen::MatrixXd of_columns(Eigen::MatrixXd columns) const;
  /// 1 at the measured ones of the first `rows` rows, 0 at the others; empty where all were measured.
  [[nodiscard]] Eigen::VectorXd weights(Eigen::Index rows) const;

 private:
  [[nodiscard]] std::vector<Eigen::Index> kept(Eigen::Index rows) const;

  std::vector<Eigen::Index> left_out_;  ///< ascending
};

/// How many rows of a record were not measured.
struct Unmeasured {
  std::size_t rows = 0;
  /// Of these, whose input is not known either: what the plant did there nobody can tell.
  std::size_t without_input = 0;
  std::size_t in_gaps = 0;  ///< of those, in gaps of kRowsOfGap rows or more
  std::size_t of_rows = 1;  ///< all of the record

  [[nodiscard]] double percent() const { return 100.0 * static_cast<double>(rows) / static_cast<double>(of_rows); }
  [[nodiscard]] double without_input_percent() const {
    return 100.0 * static_cast<double>(without_input) / static_cast<double>(of_rows);
  }
  [[nodiscard]] double in_gaps_percent() const {
    return 100.0 * static_cast<double>(in_gaps) / static_cast<double>(of_rows);
  }
};

/// Of a record whose rows lack both values. Cost O(unmeasured).
[[nodiscard]] Unmeasured unmeasured_of(const Record& record);

/// @param without_input  of the record's rows that were not measured, those without an input, ascending
[[nodiscard]] Unmeasured unmeasured_of(const Record& record, const std::vector<std::size_t>& without_input);

/// The rows [first, first + count) of a list of rows, counted from there.
[[nodiscard]] std::vector<std::size_t> rows_within(const std::vector<std::size_t>& rows, std::size_t first,
                                                   std::size_t count);

}  // namespace eha::ident
