// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "daemon/identify/cross_validation.hpp"
#include "daemon/identify/executor.hpp"
#include "daemon/identify/frequency_comparison.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/excitation/excitation.hpp"
#include "ident/uncertainty/usable_band.hpp"
#include "ident/validation/measured_noise.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::identify {
namespace {

constexpr std::size_t kQuicklyCompared_rows = 1'000'000;

/// Where the input moves that a model was estimated from.
std::optional<ident::FrequencyInterval> excited_by(const IdentificationTask& task, const ident::FitResult& result) {
  if (task.excited) return task.excited;
  const auto rows = static_cast<Eigen::Index>(result.estimation_samples);
  if (rows < 1 || result.time_s.size() < rows) return {};
  const double last = std::round((result.time_s[rows - 1] - task.record.start_s) / task.record.step_s);
  return ident::excited_band(task.record.input.head(static_cast<Eigen::Index>(last) + 1), task.record.step_s);
}

/// Lowest and highest line of the source's experiment, if it has lines.
std::optional<ident::FrequencyInterval> excited_lines_of(const Source& source) {
  if (!source.experiment) return {};
  const auto samples = static_cast<std::size_t>(source.record.input.size());
  const std::size_t table = source.repetition_samples > 0 ? source.repetition_samples : samples;
  const std::vector<double> lines_Hz = ident::excited_lines(source.experiment->excitation, source.record.step_s, table);
  if (lines_Hz.empty()) return {};
  return ident::FrequencyInterval{lines_Hz.front(), lines_Hz.back()};
}

IdentifiedModel identify_one(const IdentificationTask& task, const ident::StructureOptions& structure) {
  const auto begin = std::chrono::steady_clock::now();
  IdentifiedModel identified{structure, ident::fit(task.record, structure, task.options, thread_executor())};
  ident::Model& model = identified.result.model;
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
  if (model.estimation) model.estimation->seconds = taken.count();
  model.verdict = ident::judge(model, task.acceptance,
                               {.interpolated_percent = task.interpolated_percent, .noise_std = task.noise_std});
  if (const auto excited = excited_by(task, identified.result)) {
    model.verdict->usable_band = ident::usable_band(model, identified.result.covariance, *excited, task.acceptance);
  }
  model.provenance["record"] = task.source_name;
  model.provenance["seed"] = fmt::format("{}", task.options.seed);
  model.provenance["decimation"] = fmt::format("{}", task.options.decimation);
  model.provenance["discard_s"] = fmt::format("{}", task.options.discard_s);
  model.provenance["split"] = fmt::format("{}", task.options.split);
  model.provenance["software"] = fmt::format("eha {}", EHA_VERSION);
  return identified;
}

}  // namespace

IdentificationTask task_of(const Source& source) {
  IdentificationTask task{.record = source.record,
                          .source_name = source.name,
                          .interpolated_percent = interpolated_percent(source),
                          .repetition_samples = source.repetition_samples};
  if (source.experiment) {
    task.structures = source.experiment->models;
    task.options = source.experiment->fit;
    task.acceptance = source.experiment->acceptance;
  }
  return task;
}

std::optional<std::string> size_warning(std::size_t rows, int decimation) {
  const std::size_t compared = rows / static_cast<std::size_t>(std::max(1, decimation));
  if (compared <= kQuicklyCompared_rows) return std::nullopt;
  return fmt::format(
      "{} rows are to be compared, which may take minutes; --decimate {} compares filtered "
      "samples of them and is nearly as exact for a plant that is slow beside the sampling",
      compared, (rows + kQuicklyCompared_rows - 1) / kQuicklyCompared_rows);
}

Identification identify(const Source& source, const IdentificationTask& task, const Comparisons& comparisons,
                        const Progress& progress) {
  Identification identification;
  IdentificationTask known = task;
  known.excited = excited_lines_of(source);
  identification.frequency_response = frequency_response_of(source, task.options, identification.notes);
  if (identification.frequency_response) {
    known.noise_std = ident::measured_noise(source.record.output, identification.frequency_response->periods,
                                            task.options.decimation);
  }
  identification.models = fit_models(known, progress);
  identification.recommendation = recommend(identification.models, task);
  if (comparisons.paper == Comparisons::Paper::include) {
    identification.paper = fit_as_in_the_paper(known, identification.warnings);
  }
  if (comparisons.cross_validation == Comparisons::CrossValidation::include) {
    identification.cross_validation = cross_validate(task, progress);
  }
  return identification;
}

std::vector<IdentifiedModel> fit_models(const IdentificationTask& task, const Progress& progress) {
  std::vector<IdentifiedModel> models;
  const double count = static_cast<double>(task.structures.size());
  for (const ident::StructureOptions& structure : task.structures) {
    if (progress) progress(static_cast<double>(models.size()) / count, fmt::format("fitting {}", structure.name));
    try {
      models.push_back(identify_one(task, structure));
    } catch (const DataError& error) {
      throw DataError(fmt::format("{}: {}", task.source_name, error.what()));
    }
  }
  return models;
}

std::vector<IdentifiedModel> fit_as_in_the_paper(IdentificationTask task, std::vector<std::string>& warnings) {
  if (task.options.procedure == ident::Procedure::paper) return {};
  task.options.procedure = ident::Procedure::paper;
  task.options.input_before.reset();
  std::vector<IdentifiedModel> models;
  for (const ident::StructureOptions& structure : task.structures) {
    const auto published = ident::published_structure(structure.structure);
    if (!published) continue;
    ident::StructureOptions plain;
    plain.name = structure.name;
    plain.structure = *published;
    try {
      models.push_back(identify_one(task, plain));
    } catch (const Error& error) {
      warnings.push_back(
          fmt::format("no comparison with the paper's procedure for {}: {}", structure.name, error.what()));
    }
  }
  return models;
}

ident::Recommendation recommend(const std::vector<IdentifiedModel>& models, const IdentificationTask& task) {
  std::vector<const ident::Model*> all;
  for (const IdentifiedModel& identified : models) all.push_back(&identified.result.model);
  return ident::recommend(all, task.acceptance, task.interpolated_percent);
}

bool is_accepted(const IdentifiedModel& identified) {
  return identified.result.model.verdict && identified.result.model.verdict->accepted;
}

ExitCode exit_code(const std::vector<IdentifiedModel>& models) {
  if (std::any_of(models.begin(), models.end(), is_accepted)) return ExitCode::ok;
  const bool converged = std::any_of(models.begin(), models.end(), [](const IdentifiedModel& identified) {
    return identified.result.model.estimation && identified.result.model.estimation->converged;
  });
  return converged ? ExitCode::model_rejected : ExitCode::not_converged;
}

}  // namespace eha::identify
