// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/sweep_command.hpp"

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/shell_word.hpp"
#include "daemon/eha/console.hpp"
#include "daemon/eha/fit_command.hpp"
#include "daemon/eha/new_folders.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "daemon/identify/sweep.hpp"
#include "daemon/importer/asked_command.hpp"
#include "ident/model/model_file.hpp"

namespace eha::cli {
namespace {

std::string table(const std::vector<ident::SweepPoint>& sweep) {
  const std::vector<Column> columns{{"q", Align::right},         {"est. R2 %", Align::right}, {"fit %", Align::right},
                                    {"val. R2 %", Align::right}, {"fit %", Align::right},     {"AR-BIC", Align::right},
                                    {"stable", Align::left},     {"margin rad", Align::right}};
  std::vector<std::vector<std::string>> rows;
  for (const ident::SweepPoint& point : sweep) {
    std::vector<std::string> row{fmt::format("{:.3f}", point.commensurate_order)};
    if (point.model) {
      const ident::Model& m = *point.model;
      const auto score = [&row](const ident::Score* s) {
        row.push_back(s != nullptr ? fmt::format("{:.3f}", s->r2_percent) : "-");
        row.push_back(s != nullptr ? fmt::format("{:.2f}", s->fit_percent) : "-");
      };
      score(&m.estimation->score);
      score(m.validation ? &m.validation->score : nullptr);
      row.push_back(fmt::format("{:.1f}", m.estimation->information->ar_bic));
      row.emplace_back(m.stability->stable ? "yes" : "no");
      row.push_back(fmt::format("{:.3f}", m.stability->margin_rad));
    } else {
      row.insert(row.end(), {"-", "-", "-", "-", "-", "none", "-"});
    }
    rows.push_back(std::move(row));
  }
  return text_table(columns, rows);
}

std::vector<double> orders_of(const FitCommand& command) {
  try {
    return ident::order_grid(command.sweep_orders.at(0), command.sweep_orders.at(1), command.sweep_orders.at(2));
  } catch (const ConfigError& error) {
    throw UsageError(fmt::format("--sweep-orders: {}", error.what()));
  }
}

nlohmann::ordered_json to_json(const std::vector<ident::SweepPoint>& sweep) {
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const ident::SweepPoint& point : sweep) {
    nlohmann::ordered_json entry{{"q", point.commensurate_order}};
    if (point.model) entry["model"] = nlohmann::ordered_json::parse(ident::to_text(*point.model));
    points.push_back(std::move(entry));
  }
  return points;
}

}  // namespace

ExitCode sweep_commensurate_order(const FitCommand& command, const identify::IdentificationTask& task,
                                  const std::optional<std::filesystem::path>& folder, Console& console) {
  const std::vector<double> orders = orders_of(command);
  std::optional<NewFolders> made;
  if (folder) made.emplace(*folder);
  const identify::CommensurateSweep sweep =
      identify::sweep_commensurate_order(task, orders, console.progress_callback());
  console.end_progress();

  nlohmann::ordered_json document{
      {"schema", "eha-sweep/1"}, {"source", command.source}, {"points", to_json(sweep.points)}};
  console.print(table(sweep.points));
  document["files"] = nlohmann::ordered_json::array();
  if (folder) {
    const std::filesystem::path path = *folder / "sweep_commensurate.csv";
    os::write_file_atomically(path, ident::to_csv(sweep.points));
    document["files"].push_back(os::shown(path));
    console.print(fmt::format("written: {}", os::shown(path)));
  } else {
    console.print("Nothing written; -o DIR writes DIR/sweep_commensurate.csv.");
  }
  console.print_json(document);
  if (!sweep.best) return ExitCode::not_converged;
  const ident::Structure& structure = sweep.structure.structure;
  importer::Options asked = command.import;
  asked.command = importer::command_without(asked, {"--sweep", "--sweep-orders", "--model", "--poles", "--start"});
  console.next_step(importer::command_with(
      asked, command.source,
      fmt::format("--model {} --poles {} --start {}={:.4g}", structure.family, state_count(structure),
                  structure.base_order->key.name, sweep.points[*sweep.best].commensurate_order)));
  return ExitCode::ok;
}

}  // namespace eha::cli
