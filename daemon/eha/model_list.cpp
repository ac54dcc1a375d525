// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_list.hpp"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "daemon/eha/text_table.hpp"

namespace eha::cli {

using Json = nlohmann::ordered_json;

void print_model_list(const Json& models, const Console& console) {
  std::vector<std::vector<std::string>> rows;
  const auto percent = [](const Json& model, const char* key) {
    const auto found = model.find(key);
    return found != model.end() && found->is_number() ? fmt::format("{:.2f}", found->get<double>()) : std::string("-");
  };
  for (const Json& model : models) {
    rows.push_back({model.value("name", "?"), percent(model, "estimation_r2_percent"),
                    percent(model, "validation_r2_percent"), percent(model, "validation_r2_percent_offset_reestimated"),
                    model.value("accepted", false) ? "accepted" : "rejected", model.value("file", "-")});
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
  for (const Json& model : models) {
    for (const Json& reason : model.value("reasons", Json::array())) {
      console.print(
          fmt::format("{}: {}", model.value("name", "?"), reason.is_string() ? reason.get<std::string>() : ""));
    }
  }
}

}  // namespace eha::cli
