// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/refit.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/error.hpp"
#include "core/time_text.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::identify {

using Eigen::Index;

double rms_error_of(const ident::Model& model) { return std::sqrt(model.estimation->score.mse); }

bool misses_something(const ident::Model& model) {
  using Kind = ident::CriterionKind;
  return !model.verdict ||
         ident::fails_any(*model.verdict,
                          {Kind::r2, Kind::residual_input, Kind::residual_whiteness, Kind::nonlinearity,
                           Kind::future_input, Kind::predicted_error, Kind::residual_drift, Kind::jump,
                           Kind::error_over_estimating, Kind::error_over_noise, Kind::far_error_over_noise});
}

namespace {

/// Whether the fastest pole of a model is faster than a row shows: no search goes on from there.
bool has_vanished_pole(const ident::Model& model, double step_s) {
  constexpr double kVanished = 0.05;  // of a row
  const std::vector<ident::Term>& all = model.transfer_function.denominator;
  if (all.size() < 2 || !(all.front().order > all[1].order)) return false;
  const double time = std::abs(all.front().coefficient / all[1].coefficient);
  return std::pow(time, 1.0 / (all.front().order - all[1].order)) < kVanished * step_s;
}

}  // namespace

std::optional<Refit> least_error_of(const std::vector<const IdentifiedModel*>& bases, const ident::Record& record,
                                    ident::FitOptions options, ident::Reported reported) {
  options.intervals = ident::IntervalMethod::straight;
  options.reported = reported;
  const double step_s = record.step_s * static_cast<double>(options.decimation);
  // What is wrong with a column may lie in the part that judges.
  options.split = 1.0;
  std::optional<Refit> best;
  for (const IdentifiedModel* base : bases) {
    try {
      options.search = has_vanished_pole(base->result.model, step_s) ? ident::Search::known : ident::Search::nearest;
      const ident::PreparedRecord prepared(record, options);
      const ident::Model model =
          ident::fit(prepared, base->structure, options, thread_executor(), {base->result.model}).model;
      if (!model.estimation) continue;
      if (!best || rms_error_of(model) < best->error) best = Refit{rms_error_of(model), base->structure.name, model};
    } catch (const DataError&) {
      continue;  // this structure cannot be fitted to it
    }
  }
  return best;
}

ident::Record rows_from(const ident::Record& record, Index first, Index count) {
  ident::Record found = record;
  found.input = record.input.segment(first, count);
  found.output = record.output.segment(first, count);
  found.unmeasured =
      ident::rows_within(record.unmeasured, static_cast<std::size_t>(first), static_cast<std::size_t>(count));
  return found;
}

ident::Record tried_rows(const ident::Record& record, Index parts) {
  return rows_from(record, 0, std::min<Index>(record.input.size(), kMostTriedRows * parts));
}

std::string time_at(const ident::Record& record, Index row) {
  return time_text(record.start_s + static_cast<double>(row) * record.step_s);
}

std::optional<std::pair<Index, Index>> longest_without(const Stretches& stretches, Index rows) {
  constexpr double kLongPartOfRecord = 0.2;
  Index begin = 0;
  Index first = 0;
  Index behind = 0;
  const auto take = [&](Index end) {
    if (end - begin <= behind - first) return;
    first = begin;
    behind = end;
  };
  for (const auto& [from, to] : stretches) {
    take(from);
    begin = to + 1;
  }
  take(rows);
  if (static_cast<double>(behind - first) < kLongPartOfRecord * static_cast<double>(rows)) return std::nullopt;
  return std::pair{first, behind};
}

std::string cut_to(const std::pair<Index, Index>& part, const ident::Record& record) {
  std::string options = part.first > 0 ? "--from " + time_at(record, part.first) : "";
  if (part.second < record.input.size()) {
    options += (options.empty() ? "--to " : " --to ") + time_at(record, part.second - 1);
  }
  return options;
}

}  // namespace eha::identify
