// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/cross_validation.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "daemon/eha/executor.hpp"
#include "daemon/eha/text_table.hpp"

namespace eha::cli {
namespace {

/// The record up to the end of a repetition, and options that compare that repetition alone.
struct Part {
  ident::Record record;
  ident::FitOptions options;
};

Part part_up_to(const IdentificationTask& task, std::size_t repetition, std::size_t samples) {
  Part part{task.record, task.options};
  const auto rows = static_cast<Eigen::Index>((repetition + 1) * samples);
  part.record.input = task.record.input.head(rows);
  part.record.output = task.record.output.head(rows);
  const double begin_s = static_cast<double>(repetition * samples) * task.record.step_s;
  part.options.discard_s = std::max(task.options.discard_s, begin_s);
  part.options.split = 1.0;
  part.options.intervals = ident::IntervalMethod::straight;
  return part;
}

/// A state at the first row has died away before a later repetition: that one cannot tell it, and what it made of noise
/// would grow without bound towards the first row.
ident::StructureOptions seen_from(std::size_t repetition, ident::StructureOptions structure) {
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

/// Mean R2 of the repetitions that did not estimate.
double mean_on_others(const std::vector<ident::Score>& scores, std::size_t estimated_on) {
  double sum = 0.0;
  for (std::size_t q = 0; q < scores.size(); ++q) sum += q == estimated_on ? 0.0 : scores[q].r2_percent;
  return sum / static_cast<double>(scores.size() - 1);
}

}  // namespace

std::vector<CrossValidatedModel> cross_validate(const IdentificationTask& task, std::size_t repetition_samples,
                                                Console& console) {
  if (task.options.procedure == ident::Procedure::paper) {
    throw UsageError("--cross-validate: the paper's procedure cuts the history off; expected --procedure default");
  }
  const auto rows = static_cast<std::size_t>(task.record.input.size());
  const std::size_t repetitions = repetition_samples > 0 ? rows / repetition_samples : 0;
  if (repetitions < 2) {
    throw DataError(
        fmt::format("{}: --cross-validate: the record holds {} whole repetition{}; expected at least 2: a "
                    "run with repetitions, or --experiment with the length of one",
                    task.source_name, repetitions, repetitions == 1 ? "" : "s"));
  }
  std::vector<Part> parts;
  for (std::size_t r = 0; r < repetitions; ++r) parts.push_back(part_up_to(task, r, repetition_samples));
  std::vector<CrossValidatedModel> models;
  const auto fits = static_cast<double>(task.structures.size() * repetitions);
  for (const ident::StructureOptions& structure : task.structures) {
    for (std::size_t r = 0; r < repetitions; ++r) {
      console.progress(static_cast<double>(models.size()) / fits,
                       fmt::format("fitting {} on repetition {}", structure.name, r + 1));
      try {
        const ident::FitResult fitted =
            ident::fit(parts[r].record, seen_from(r, structure), parts[r].options, thread_executor());
        models.push_back(score_on_all(fitted, parts, r));
      } catch (const DataError& error) {
        throw DataError(fmt::format("{}: --cross-validate: repetition {}: {}", task.source_name, r + 1, error.what()));
      }
    }
  }
  console.end_progress();
  return models;
}

std::string cross_validation_table(const std::vector<CrossValidatedModel>& models) {
  if (models.empty()) return "";
  const std::size_t repetitions = models.front().scores.size();
  std::vector<Column> columns{{"model", Align::left}, {"estimated on", Align::right}};
  for (std::size_t q = 0; q < repetitions; ++q) columns.push_back({fmt::format("R2 % on {}", q + 1), Align::right});
  columns.push_back({"others R2 %", Align::right});
  columns.push_back({"re. R2 %", Align::right});
  std::vector<std::vector<std::string>> rows;
  for (const CrossValidatedModel& model : models) {
    std::vector<std::string> row{model.name, fmt::format("{}", model.estimated_on + 1)};
    for (std::size_t q = 0; q < repetitions; ++q) {
      const std::string r2 = fmt::format("{:.2f}", model.scores[q].r2_percent);
      row.push_back(q == model.estimated_on ? "(" + r2 + ")" : r2);
    }
    row.push_back(fmt::format("{:.2f}", mean_on_others(model.scores, model.estimated_on)));
    row.push_back(fmt::format("{:.2f}", mean_on_others(model.offset_reestimated, model.estimated_on)));
    rows.push_back(std::move(row));
  }
  return "cross-validation between repetitions\n" + text_table(columns, rows) +
         "in brackets: the repetition that estimated; others: mean of the rest, offset kept; re.: offset "
         "re-estimated\n";
}

nlohmann::ordered_json cross_validation_json(const std::vector<CrossValidatedModel>& models) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const CrossValidatedModel& model : models) {
    nlohmann::ordered_json scores = nlohmann::ordered_json::array();
    for (std::size_t q = 0; q < model.scores.size(); ++q) {
      scores.push_back({{"repetition", q + 1},
                        {"estimated_here", q == model.estimated_on},
                        {"r2_percent", model.scores[q].r2_percent},
                        {"mse", model.scores[q].mse},
                        {"fit_percent", model.scores[q].fit_percent},
                        {"r2_percent_offset_reestimated", model.offset_reestimated[q].r2_percent}});
    }
    list.push_back(
        {{"name", model.name},
         {"estimated_on", model.estimated_on + 1},
         {"scores", std::move(scores)},
         {"others_r2_percent", mean_on_others(model.scores, model.estimated_on)},
         {"others_r2_percent_offset_reestimated", mean_on_others(model.offset_reestimated, model.estimated_on)}});
  }
  return list;
}

}  // namespace eha::cli
