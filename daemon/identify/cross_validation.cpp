// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/identify/cross_validation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/identify/thread_executor.hpp"
#include "ident/signal/measured_rows.hpp"

namespace eha::identify {
namespace {

/// The record up to the end of a repetition, and options to compare that repetition alone.
struct Part {
  ident::Record record;
  ident::FitOptions options;
};

Part part_up_to(const IdentificationTask& task, std::size_t repetition, std::size_t samples) {
  Part part{task.record, task.options};
  const auto rows = static_cast<Eigen::Index>((repetition + 1) * samples);
  part.record.input = task.record.input.head(rows);
  part.record.output = task.record.output.head(rows);
  part.record.unmeasured = ident::rows_within(task.record.unmeasured, 0, static_cast<std::size_t>(rows));
  const double begin_s = static_cast<double>(repetition * samples) * task.record.step_s;
  part.options.discard_s = std::max(task.options.discard_s, begin_s);
  part.options.split = 1.0;
  part.options.intervals = ident::IntervalMethod::straight;
  return part;
}

/// Returns the structure to estimate on one repetition. Only the first repetition estimates an initial state: in a
/// later one its response has decayed, and noise fitted as that response would grow without bound towards the first
/// row.
ident::StructureOptions structure_for(std::size_t repetition, ident::StructureOptions structure) {
  if (repetition > 0) structure.initial_state = ident::InitialState::none;
  return structure;
}

CrossValidatedModel score_on_all(const ident::FitResult& fitted, const std::vector<Part>& parts,
                                 std::size_t estimated_on) {
  CrossValidatedModel model{fitted.model.name, estimated_on, {}, {}};
  for (const Part& part : parts) {
    const ident::ValidationReport report = ident::validate(fitted.model, part.record, part.options);
    model.scores.push_back(report.score);
    model.offset_reestimated.push_back(report.offset_reestimated.value_or(report.score));
  }
  return model;
}

}  // namespace

double mean_r2_percent(const std::vector<ident::Score>& scores, std::size_t estimated_on) {
  double sum = 0.0;
  for (std::size_t q = 0; q < scores.size(); ++q) sum += q == estimated_on ? 0.0 : scores[q].r2_percent;
  return sum / static_cast<double>(scores.size() - 1);
}

std::vector<CrossValidatedModel> cross_validate(const IdentificationTask& task, const Progress& progress) {
  if (task.options.procedure == ident::Procedure::paper) {
    throw UsageError("--cross-validate: the paper's procedure cuts the history off; expected --procedure default");
  }
  const auto rows = static_cast<std::size_t>(task.record.input.size());
  const std::size_t repetitions = task.repetition_samples > 0 ? rows / task.repetition_samples : 0;
  if (repetitions < 2) {
    throw DataError(
        fmt::format("{}: --cross-validate: the record holds {} whole repetition{}; expected at least 2: a "
                    "run with repetitions, or --experiment with the length of one",
                    task.source_name, repetitions, repetitions == 1 ? "" : "s"));
  }
  std::vector<Part> parts;
  for (std::size_t r = 0; r < repetitions; ++r) parts.push_back(part_up_to(task, r, task.repetition_samples));
  std::vector<CrossValidatedModel> models;
  const auto fits = static_cast<double>(task.structures.size() * repetitions);
  for (const ident::StructureOptions& structure : task.structures) {
    for (std::size_t r = 0; r < repetitions; ++r) {
      if (progress) {
        progress(static_cast<double>(models.size()) / fits,
                 fmt::format("fitting {} on repetition {}", structure.name, r + 1));
      }
      try {
        const ident::FitResult fitted =
            ident::fit(parts[r].record, structure_for(r, structure), parts[r].options, thread_executor());
        models.push_back(score_on_all(fitted, parts, r));
      } catch (const DataError& error) {
        throw DataError(fmt::format("{}: --cross-validate: repetition {}: {}", task.source_name, r + 1, error.what()));
      }
    }
  }
  return models;
}

}  // namespace eha::identify
