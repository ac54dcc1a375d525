// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/published/published_study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "daemon/identify/identification.hpp"
#include "daemon/identify/thread_executor.hpp"
#include "daemon/published/set_records.hpp"
#include "daemon/published/test_start.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/model/model_output.hpp"
#include "ident/validation/score.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::published {
namespace {

constexpr double kClearGain = 10.0;  // of AR-BIC

using Files = std::vector<std::filesystem::path>;

std::vector<std::string> missing_of(const PublishedSet& set, const Files& files) {
  std::vector<std::string> missing;
  const auto look_for = [&](const Part& part) {
    if (!found(part, files).empty()) return;
    const std::string names = fmt::format("{}", fmt::join(part.files, " or "));
    if (std::find(missing.begin(), missing.end(), names) == missing.end()) missing.push_back(names);
  };
  look_for(set.estimation);
  for (const Test& test : set.tests) look_for(test.part);
  return missing;
}

/// Returns the model that would be recommended without a limit on R2, which publications do not have; empty: none.
std::string best_without_limit(std::vector<identify::IdentifiedModel> models, identify::IdentificationTask task) {
  task.acceptance.min_validation_r2_percent = 0.0;
  for (identify::IdentifiedModel& identified : models) {
    ident::Model& model = identified.result.model;
    const auto band = model.verdict->usable_band;
    model.verdict = ident::judge(model, task.acceptance);
    model.verdict->usable_band = band;
  }
  return identify::recommend(models, task).model;
}

/// Fits the grey boxes whose linear form the ladder's model is. One that is accepted and has a clearly lower AR-BIC
/// takes its place.
void try_grey_boxes(StudiedSet& studied, const identify::IdentificationTask& task) {
  const ident::Model linear = *studied.model;
  const auto ar_bic = [](const ident::Model& model) {
    const auto& information = model.estimation->information;
    return information ? information->ar_bic : std::numeric_limits<double>::infinity();
  };
  for (const ident::StructureFamily& family : ident::structure_families()) {
    ident::StructureOptions asked{.name = std::string(family.name), .structure = family.make({})};
    if (!asked.structure.grey_box || !ident::is_linear_form_of(*asked.structure.grey_box->kind, linear)) continue;
    ident::Model model;
    try {
      model = ident::fit(task.record, asked, task.options, identify::thread_executor()).model;
    } catch (const DataError& error) {
      studied.recommendation += fmt::format(" {}: not fitted, {}.", asked.name, error.what());
      continue;
    }
    model.verdict = ident::judge(model, task.acceptance);
    const double gain = ar_bic(*studied.model) - ar_bic(model);
    const bool is_taken = model.verdict->accepted && gain > kClearGain;
    studied.recommendation += fmt::format(" {}: {}, its AR-BIC is {:.1f} {} that of {}.", model.name,
                                          is_taken ? "taken in its place" : "not taken", std::abs(gain),
                                          gain > 0.0 ? "below" : "above", studied.model->name);
    if (is_taken) studied.model = std::move(model);
  }
}

/// Climbs the ladder on the estimating part, all rows of which estimate.
void fit(StudiedSet& studied, ident::Record record, const identify::Progress& progress) {
  const PublishedSet& set = *studied.set;
  identify::Source source;
  source.name = std::string(set.name);
  source.record = std::move(record);
  identify::IdentificationTask task = identify::task_of(source);
  task.options.split = 1.0;
  task.options.decimation = set.decimation;
  const auto begin = std::chrono::steady_clock::now();
  const identify::Identification identification = identify::identify(source, task, {}, progress);
  const ident::Recommendation& recommendation = identification.recommendation;
  studied.is_recommended = !recommendation.model.empty();
  studied.recommendation = ident::sentence(recommendation);
  const std::string name =
      studied.is_recommended ? recommendation.model : best_without_limit(identification.models, task);
  for (const identify::IdentifiedModel& identified : identification.models) {
    if (identified.result.model.name == name) studied.model = identified.result.model;
  }
  if (!studied.model) {
    studied.failure = studied.recommendation;
    return;
  }
  try_grey_boxes(studied, task);
  studied.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Returns the score with offset and state fitted to all rows from `first` on.
ident::Score score_with_start_fitted(const ident::Model& model, const ident::Record& record, std::size_t first) {
  const auto all = static_cast<std::size_t>(record.output.size());
  const ident::Comparison rows{.first = first, .every = 1, .count = all - first, .taps = {}};
  const ident::ModelOutput output = ident::OutputOnRecord(record, rows).of(model);
  const Eigen::VectorXd measured = record.output.tail(static_cast<Eigen::Index>(rows.count));
  return ident::score(measured, output.total(ident::with_offset_fitted(model, output, measured)));
}

ScoredTest scored(const Test& test, const ident::Model& model, const ident::Record& estimating, const Part& estimated,
                  const Files& files) {
  ScoredTest result{.test = &test};
  Part simulated_part = test.part;
  std::size_t unscored = test.start_rows;
  if (test.begin == Begin::continued) {
    unscored = test.part.first - estimated.first;
    simulated_part.first = estimated.first;
    if (test.part.rows > 0) simulated_part.rows = unscored + test.part.rows;
    result.is_of_estimating_rows = unscored < static_cast<std::size_t>(estimating.output.size());
  }
  const ident::Record record = read_part(simulated_part, found(test.part, files), estimating.step_s);
  const ident::Model from =
      test.begin == Begin::continued ? model : started(model, record, test.start_rows, estimating);
  const Eigen::VectorXd output = ident::simulate(from, record.input, record.step_s);
  const Eigen::Index rows = record.output.size() - static_cast<Eigen::Index>(unscored);
  if (rows < 1)
    throw DataError(fmt::format("{}: no row of the test {} is left to score", estimated.files.front(), test.name));
  result.measured = record.output.tail(rows);
  result.simulated = output.tail(rows);
  result.time_s = Eigen::VectorXd::LinSpaced(rows, 0.0, record.step_s * static_cast<double>(rows - 1));
  result.time_s.array() += record.step_s * static_cast<double>(test.begin == Begin::continued ? 0 : unscored);
  result.score = test.factor * test.measure.value(ident::score(result.measured, result.simulated));
  if (test.begin == Begin::anew) {
    const ident::Score fitted = score_with_start_fitted(from, record, unscored);
    result.with_start_fitted = test.factor * test.measure.value(fitted);
  }
  return result;
}

StudiedSet studied(const PublishedSet& set, const Files& files, const identify::Progress& progress) {
  StudiedSet result{.set = &set};
  result.missing_files = missing_of(set, files);
  if (result.is_absent()) return result;
  try {
    const ident::Record record = read_part(set.estimation, found(set.estimation, files), set.period_s);
    result.estimating_rows = static_cast<std::size_t>(record.output.size());
    fit(result, record, progress);
    if (!result.model) return result;
    for (const Test& test : set.tests) {
      result.tests.push_back(scored(test, *result.model, record, set.estimation, files));
    }
  } catch (const Error& error) {
    result.failure = error.what();
  }
  return result;
}

}  // namespace

std::vector<StudiedSet> study_published(std::span<const PublishedSet> sets, const std::filesystem::path& folder,
                                        const StudyProgress& progress) {
  const Files files = files_below(folder);
  std::vector<StudiedSet> all;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const auto of_one = [&](double share, const std::string& step) {
      if (!progress || step.ends_with('\n')) return;  // the table has the ladder's results
      progress((static_cast<double>(i) + share) / static_cast<double>(sets.size()),
               fmt::format("{}: {}", sets[i].name, step));
    };
    all.push_back(studied(sets[i], files, of_one));
  }
  return all;
}

}  // namespace eha::published
