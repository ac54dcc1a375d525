// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/cross_validation_table.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <utility>

#include "daemon/eha/terminal_table.hpp"
#include "daemon/identify/cross_validation.hpp"

namespace eha::cli {

std::string cross_validation_table(const std::vector<identify::CrossValidatedModel>& models) {
  if (models.empty()) return "";
  const std::size_t repetitions = models.front().scores.size();
  std::vector<Column> columns{{"model", Align::left}, {"estimated on", Align::right}};
  for (std::size_t q = 0; q < repetitions; ++q) columns.push_back({fmt::format("R2 % on {}", q + 1), Align::right});
  columns.push_back({"others R2 %", Align::right});
  columns.push_back({"re. R2 %", Align::right});
  std::vector<std::vector<std::string>> rows;
  for (const identify::CrossValidatedModel& model : models) {
    std::vector<std::string> row{model.name, fmt::format("{}", model.estimated_on + 1)};
    for (std::size_t q = 0; q < repetitions; ++q) {
      const std::string r2 = fmt::format("{:.2f}", model.scores[q].r2_percent);
      row.push_back(q == model.estimated_on ? "(" + r2 + ")" : r2);
    }
    row.push_back(fmt::format("{:.2f}", identify::mean_r2_percent(model.scores, model.estimated_on)));
    row.push_back(fmt::format("{:.2f}", identify::mean_r2_percent(model.offset_reestimated, model.estimated_on)));
    rows.push_back(std::move(row));
  }
  return "cross-validation between repetitions\n" + text_table(columns, rows) +
         "in brackets: the repetition that estimated; others: mean of the rest, offset kept; re.: offset "
         "re-estimated\n";
}

nlohmann::ordered_json cross_validation_json(const std::vector<identify::CrossValidatedModel>& models) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const identify::CrossValidatedModel& model : models) {
    nlohmann::ordered_json scores = nlohmann::ordered_json::array();
    for (std::size_t q = 0; q < model.scores.size(); ++q) {
      scores.push_back({{"repetition", q + 1},
                        {"estimated_here", q == model.estimated_on},
                        {"r2_percent", model.scores[q].r2_percent},
                        {"mse", model.scores[q].mse},
                        {"fit_percent", model.scores[q].fit_percent},
                        {"r2_percent_offset_reestimated", model.offset_reestimated[q].r2_percent}});
    }
    list.push_back({{"name", model.name},
                    {"estimated_on", model.estimated_on + 1},
                    {"scores", std::move(scores)},
                    {"others_r2_percent", identify::mean_r2_percent(model.scores, model.estimated_on)},
                    {"others_r2_percent_offset_reestimated",
                     identify::mean_r2_percent(model.offset_reestimated, model.estimated_on)}});
  }
  return list;
}

}  // namespace eha::cli
