// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/judging_part.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "ident/estimation/fit_rows.hpp"

namespace eha::ident {
namespace {

// Standard deviation in the judging part over the range in the estimating one.
// An input is computed or measured with little noise; an output still settles,
// and has noise.
constexpr double kInputRests = 0.01;
constexpr double kOutputRests = 0.05;

bool rests(const Eigen::VectorXd &values, const FitRows &rows,
           const std::optional<double> &before, double share) {
  const auto first = static_cast<Eigen::Index>(rows.discarded);
  const auto judging = static_cast<Eigen::Index>(rows.last) + 1;
  const auto estimating = values.segment(first, judging - first);
  const auto judged = values.tail(values.size() - judging);
  const double least =
      std::min(estimating.minCoeff(), before.value_or(estimating[0]));
  const double greatest =
      std::max(estimating.maxCoeff(), before.value_or(estimating[0]));
  const double deviation =
      std::sqrt((judged.array() - judged.mean()).square().mean());
  return deviation <= share * (greatest - least) && greatest > least;
}

} // namespace

bool judging_part_rests(const Record &record, const FitOptions &options) {
  if (!(options.split < 1.0))
    return false;
  try {
    check_record(record, options);
    const FitRows rows = fit_rows(record, options);
    if (static_cast<Eigen::Index>(rows.last) + 1 >= record.input.size())
      return false;
    return rests(record.input, rows, options.input_before, kInputRests) &&
           rests(record.output, rows, std::nullopt, kOutputRests);
  } catch (const DataError &) {
    return false;
  }
}

} // namespace eha::ident
