// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/comparison_fits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <utility>

#include "core/error.hpp"
#include "core/os/processors.hpp"
#include "daemon/identify/compared_records.hpp"
#include "daemon/identify/judging.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "ident/estimation/delay_gain.hpp"
#include "ident/structure/structures.hpp"
#include "ident/uncertainty/usable_band.hpp"
#include "ident/validation/error_cause.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {
namespace {

/// Whether every record determines the dead band of its map, and it is none of 0.
bool shows_a_valve(const std::vector<ComparedRun>& runs) {
  return std::all_of(runs.begin(), runs.end(), [](const ComparedRun& run) {
    const std::vector<ident::ParameterEstimate>& all = run.fit.model.parameters;
    return std::any_of(all.begin(), all.end(), [](const ident::ParameterEstimate& p) {
      return p.role == ident::ParameterRole::dead_band && std::isfinite(p.std) && p.value > ident::kInterval95 * p.std;
    });
  });
}

double mse_of(const ComparedRun& run) { return run.fit.model.estimation->score.mse; }

/// Free parameters of the plant in a fit.
int free_parameters(const ComparedRun& run) {
  const std::vector<ident::ParameterEstimate>& all = run.fit.model.parameters;
  return static_cast<int>(std::count_if(all.begin(), all.end(), [](const auto& p) { return !p.fixed; }));
}

/// Whether fits with a dead time describe all records better than those without one: each errs clearly less; or one
/// errs far less, and none more; or all leave plain noise over, of which BIC judges.
bool needs_dead_time(const std::vector<ComparedRun>& with, const std::vector<ComparedRun>& without) {
  constexpr double kClearly = 0.9;  // of the rms error
  constexpr double kFar = 0.5;
  constexpr double kAlike = 1.02;
  bool err_less = true;
  bool errs_far_less = false;
  bool errs_more = false;
  bool are_plain = true;
  double bic = 0.0;
  for (std::size_t i = 0; i < with.size(); ++i) {
    const double ratio = mse_of(with[i]) / mse_of(without[i]);
    const auto samples = static_cast<double>(with[i].fit.model.estimation->score.samples);
    err_less = err_less && ratio < kClearly * kClearly;
    errs_far_less = errs_far_less || ratio < kFar * kFar;
    errs_more = errs_more || ratio > kAlike * kAlike;
    are_plain = are_plain && ident::leaves_plain_noise(with[i].fit.model);
    bic += samples * std::log(ratio) + (free_parameters(with[i]) - free_parameters(without[i])) * std::log(samples);
  }
  return err_less || (errs_far_less && !errs_more) || (are_plain && bic < 0.0);
}

}  // namespace

ComparisonFits::OfRecord::OfRecord(const Source& source, const ident::FitOptions& options,
                                   const ident::Executor& executor)
    : prepared(source.record, options), inside(prepared, options, executor) {}

ComparisonFits::ComparisonFits(const std::vector<Source>& sources, const std::vector<ident::FitOptions>& options,
                               Progress progress)
    : sources_(sources),
      options_(options),
      progress_(std::move(progress)),
      inner_(sources.size() < os::usable_processors() ? thread_executor() : ident::Executor(ident::run_in_order)) {
  for (std::size_t i = 0; i < sources.size(); ++i) {
    try {
      records_.emplace_back(sources[i], options[i], inner_);
    } catch (const DataError& error) {
      throw DataError(fmt::format("{}: {}", sources[i].name, error.what()));
    }
  }
}

ident::FitResult ComparisonFits::fitted(std::size_t nth, const ident::StructureOptions& structure) {
  const Source& source = sources_[nth];
  const Progress one_at_a_time = [this](double share, const std::string& step) {
    const std::scoped_lock lock(showing_);
    progress_(share, step);
  };
  const ident::FitProgress shown = part_of(progress_ ? one_at_a_time : Progress(), nth, sources_.size(), source.name);
  OfRecord& record = records_[nth];
  try {
    return ident::fit(record.prepared, structure, options_[nth], inner_, {}, shown, record.inside);
  } catch (const DataError& error) {
    throw DataError(fmt::format("{}: {}", source.name, error.what()));
  }
}

std::vector<ComparedRun> ComparisonFits::of(const ident::StructureOptions& structure) {
  std::vector<ComparedRun> runs(sources_.size());
  thread_executor()(sources_.size(), [&](std::size_t i) {
    ComparedRun& run = runs[i];
    run.fit = fitted(i, structure);
    ident::Model& model = run.fit.model;
    model.verdict = ident::judge(model, {});
    // As the run's own report has it.
    IdentificationTask task = task_of(sources_[i]);
    task.excited = excited_lines_of(sources_[i]);
    if (const auto excited = excited_by(task, run.fit)) {
      model.verdict->usable_band = ident::usable_band(model, run.fit.covariance, *excited, task.acceptance);
    }
  });
  return runs;
}

bool ComparisonFits::promises_dead_time(const std::vector<ComparedRun>& without, ident::StructureOptions asked) {
  asked.structure.delay.freedom = ident::Freedom::free;
  std::vector<ComparedRun> near(sources_.size());
  std::atomic<bool> is_any = false;
  thread_executor()(sources_.size(), [&](std::size_t i) {
    const ident::FitResult& found = without[i].fit;
    ident::Work ignored;
    is_any = is_any || !found.fitted || ident::predicted_delay_gain(records_[i].prepared, *found.fitted, ignored) > 0.0;
    ident::FitOptions options = options_[i];
    options.search = ident::Search::nearest;
    options.intervals = ident::IntervalMethod::straight;
    near[i].fit = ident::fit(records_[i].prepared, asked, options, inner_, {found.model});
  });
  return is_any && needs_dead_time(near, without);
}

std::vector<ComparedRun> ComparisonFits::with_dead_time(const std::vector<ComparedRun>& without,
                                                        ident::StructureOptions& structure) {
  std::vector<ComparedRun> best;
  const bool is_behind_valve = structure.structure.input_map.valve.has_value() && shows_a_valve(without);
  if (is_behind_valve && !promises_dead_time(without, structure)) return best;
  std::vector<ident::StructureOptions> families(is_behind_valve ? 1 : 2);
  if (is_behind_valve) {
    families[0] = structure;
  } else {
    families[0].structure = ident::structures::io1();
    families[1].structure = ident::structures::io();
    for (ident::StructureOptions& one : families) one.name = one.structure.family;
  }
  for (ident::StructureOptions& asked : families) {
    asked.structure.delay.freedom = ident::Freedom::free;
    try {
      std::vector<ComparedRun> runs = of(asked);
      if (!needs_dead_time(runs, best.empty() ? without : best)) continue;
      best = std::move(runs);
      structure = std::move(asked);
    } catch (const DataError&) {
      continue;  // a record cannot estimate this structure
    }
  }
  return best;
}

}  // namespace eha::identify
