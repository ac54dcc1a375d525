// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit_rows.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/rest_before_step.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::ident {

bool is_constant(const Eigen::VectorXd& v) { return (v.array() == v[0]).all(); }

void check_record(const Record& record, const FitOptions& options) {
  if (record.input.size() != record.output.size()) throw DataError("record: input and output differ in length");
  if (!record.input.allFinite() || !record.output.allFinite()) throw DataError("record: expected finite samples");
  if (!(record.step_s > 0.0)) throw DataError("record: expected a positive sample period");
  if (options.decimation < 1)
    throw ConfigError(fmt::format("decimation: expected at least 1, got {}", options.decimation));
  if (!(options.split > 0.0) || options.split > 1.0) {
    throw ConfigError(fmt::format("split: expected a share above 0 and up to 1, got {}", options.split));
  }
  if (record.input.size() < kFewestRows) {
    throw DataError(fmt::format("record: {} rows are too few to fit; expected at least {}: record longer",
                                record.input.size(), kFewestRows));
  }
  if (is_constant(record.output)) {
    throw DataError(fmt::format("record: the output is constant at {} {}: the sensor shows no motion; {}",
                                record.output[0], record.output_channel.unit, kAgainstNoMotion));
  }
}

FitRows fit_rows(const Record& record, const FitOptions& options) {
  FitRows rows;
  rows.discarded = discarded_rows(options.discard_s, record.step_s);
  rows.comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                  static_cast<std::size_t>(options.decimation), rows.discarded);
  rows.estimating = static_cast<std::size_t>(std::lround(options.split * static_cast<double>(rows.comparison.count)));
  if (rows.estimating < static_cast<std::size_t>(kFewestRows)) {
    throw DataError(fmt::format(
        "record: {} rows are left to estimate from after discarding {} s and keeping every {}th of {} rows (the "
        "anti-alias filter needs {} rows at either end); expected at least {}: "
        "record longer, or keep more of it (--discard, --decimate)",
        rows.estimating, options.discard_s, options.decimation, record.input.size(), rows.comparison.taps.size() / 2,
        kFewestRows));
  }
  const MeasuredRows measured(record, rows.comparison);
  const Eigen::Index left = measured.count(static_cast<Eigen::Index>(rows.estimating));
  if (left < kFewestRows) {
    throw DataError(fmt::format("record: {} of the {} rows to estimate from were measured; expected at least {}", left,
                                rows.estimating, kFewestRows));
  }
  rows.last = rows.comparison.first + (rows.estimating - 1) * rows.comparison.every;
  return rows;
}

std::pair<double, double> input_range(const Record& record, const FitRows& rows) {
  const auto estimating = record.input.head(static_cast<Eigen::Index>(rows.last) + 1);
  return {estimating.minCoeff(), estimating.maxCoeff()};
}

std::pair<double, double> covered_inputs(const std::pair<double, double>& range, bool has_map) {
  constexpr double kBeyond = 0.5;  // a linear model has no other gain there
  constexpr double kBeyondWithMap = 0.1;
  const double beyond = (has_map ? kBeyondWithMap : kBeyond) * (range.second - range.first);
  return {range.first - beyond, range.second + beyond};
}

std::optional<double> rest_level(const Record& record, const StructureOptions& asked, const FitOptions& options,
                                 const FitRows& rows) {
  if (options.input_before) return options.input_before;
  if (asked.initial_state == InitialState::estimated) return std::nullopt;
  const auto seen = static_cast<Eigen::Index>(rows.last) + 1;
  return rest_of_step_test(record.input.head(seen), record.output.head(seen));
}

}  // namespace eha::ident
