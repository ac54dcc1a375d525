// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_list.hpp"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "daemon/eha/terminal_table.hpp"

namespace eha::cli {

void print_model_list(const std::vector<record::ModelEntry>& models, const Console& console) {
  std::vector<std::vector<std::string>> rows;
  const auto percent = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.2f}", *value) : std::string("-");
  };
  for (const record::ModelEntry& model : models) {
    rows.push_back({model.name, percent(model.estimation_r2_percent), percent(model.validation_r2_percent),
                    percent(model.validation_r2_percent_offset_reestimated),
                    !model.grade.empty() ? model.grade
                    : model.accepted     ? "accepted"
                                         : "rejected",
                    model.file});
  }
  if (!rows.empty()) {
    console.print(text_table({{"model", Align::left},
                              {"est. R2 %", Align::right},
                              {"val. R2 %", Align::right},
                              {"re. R2 %", Align::right},
                              {"verdict", Align::left},
                              {"file", Align::left}},
                             rows));
  }
  for (const record::ModelEntry& model : models) {
    for (const std::string& reason : model.reasons) console.print(fmt::format("{}: {}", model.name, reason));
  }
}

}  // namespace eha::cli
