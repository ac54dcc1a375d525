// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/rest_before_step.hpp"

namespace eha::ident {

FitRows fit_rows(const Record& record, const FitOptions& options) {
  FitRows rows;
  rows.discarded = discarded_rows(options.discard_s, record.step_s);
  rows.comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                  static_cast<std::size_t>(options.decimation), rows.discarded);
  rows.estimating = static_cast<std::size_t>(std::lround(options.split * static_cast<double>(rows.comparison.count)));
  if (rows.estimating < static_cast<std::size_t>(kFewestRows)) {
    throw DataError(fmt::format(
        "record: {} rows are left to estimate from after discarding {} s and keeping every {}th of {} rows (the "
        "anti-alias filter needs {} rows at either end); expected at least {}",
        rows.estimating, options.discard_s, options.decimation, record.input.size(), rows.comparison.taps.size() / 2,
        kFewestRows));
  }
  rows.last = rows.comparison.first + (rows.estimating - 1) * rows.comparison.every;
  return rows;
}

std::optional<double> rest_level(const Record& record, const StructureOptions& asked, const FitOptions& options,
                                 const FitRows& rows) {
  if (options.input_before) return options.input_before;
  if (asked.initial_state == InitialState::estimated) return std::nullopt;
  const auto seen = static_cast<Eigen::Index>(rows.last) + 1;
  return rest_of_step_test(record.input.head(seen), record.output.head(seen));
}

}  // namespace eha::ident
