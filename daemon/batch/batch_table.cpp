// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/batch/batch_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/os/files.hpp"
#include "core/terminal_text.hpp"
#include "daemon/batch/compared_parameters.hpp"
#include "daemon/batch/record_labels.hpp"
#include "daemon/batch/table_text.hpp"
#include "daemon/record/csv_field.hpp"
#include "daemon/record/manifest.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_header.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::batch {
namespace {

using Json = nlohmann::ordered_json;

/// Of the unseen part; NaN where it is not known.
double fit_percent(const Json& model) {
  const Json value = model.value("validation", Json::object()).value("fit_percent", Json());
  return value.is_number() ? value.get<double>() : std::nan("");
}

std::string recommended_in(const Json& fit) {
  const auto found = fit.find("recommendation");
  if (found == fit.end() || !found->contains("model") || !found->at("model").is_string()) return "none";
  return found->at("model");
}

/// What the table needs of a model beside its document: the units of its parameters by their names, and the figures of
/// a plant that comes to rest by the names of the parameters that they replace.
void add_figures(Json& kept, const Json& document) {
  Json& units = kept["parameter_units"] = Json::object();
  try {
    const ident::Model model = ident::model_from_text(document.dump(), "result.json");
    const bool at_rest = ident::has_gain_at_rest(model);
    for (const ident::ParameterEstimate& parameter : model.parameters) {
      units[parameter.name] = ident::unit_of(parameter, model);
      const auto figure = at_rest ? ident::figure_at_rest(model, parameter) : std::nullopt;
      if (!figure) continue;
      kept[kAtRest][parameter.name] = {
          {"name", figure->name}, {"value", figure->value}, {"std", figure->std}, {"unit", figure->unit}};
    }
  } catch (const Error&) {
    // A result of another version is shown without units.
  }
}

/// Converts the models of a document of `eha fit` to a display unit.
void show_in(const DisplayUnit& unit, Json& fit) {
  for (Json& document : fit.at("models")) {
    try {
      const ident::Model model = ident::model_from_text(document.dump(), "result.json");
      if (unit.of(model.output_unit) == model.output_unit) continue;
      document = Json::parse(ident::to_text(ident::in_unit(model, unit)));
    } catch (const Error&) {
      // A result of another version is shown as it is.
    }
  }
}

/// Returns the members of a document of `eha fit` that do not depend on the place and time of the fit.
Json essence_of(const Json& fit) {
  Json models = Json::array();
  for (const Json& model : fit.at("models")) {
    Json kept;
    for (const char* key : {"name", "transfer_function", "input_map", "units", "parameters", "verdict"}) {
      if (model.contains(key)) kept[key] = model.at(key);
    }
    for (const char* key : {"r2_percent", "fit_percent", "error_min", "error_max"}) {
      if (model.contains("validation")) kept["validation"][key] = model.at("validation").at(key);
    }
    add_figures(kept, model);
    models.push_back(std::move(kept));
  }
  return {{"models", std::move(models)}, {"recommendation", fit.value("recommendation", Json())}};
}

std::string last_line(const std::string& message) {
  const std::size_t end = message.find_last_not_of('\n');
  if (end == std::string::npos) return {};
  const std::size_t begin = message.rfind('\n', end);
  std::string line = message.substr(begin == std::string::npos ? 0 : begin + 1, end - (begin + 1) + 1);
  const std::string prefix = "eha: error: ";
  return one_line(line.starts_with(prefix) ? line.substr(prefix.size()) : line);
}

/// The warnings among the messages of `eha fit`.
std::vector<std::string> warnings_in(const std::string& message) {
  constexpr std::string_view kWarning = "eha: warning: ";
  std::vector<std::string> found;
  for (std::size_t at = 0; at < message.size();) {
    const std::size_t end = std::min(message.find('\n', at), message.size());
    const std::string_view line = std::string_view(message).substr(at, end - at);
    if (line.starts_with(kWarning)) found.push_back(one_line(std::string(line.substr(kWarning.size()))));
    at = end + 1;
  }
  return found;
}

/// A warning without the name of its record.
std::string without(std::string warning, const std::string& source) {
  for (std::size_t at = warning.find(source); !source.empty() && at != std::string::npos; at = warning.find(source)) {
    warning.erase(at, source.size());
  }
  return warning;
}

/// What warnings of one kind have in common: the first clause, without the name of the record and without figures.
std::string kind_of(const std::string& warning, const std::string& source) {
  std::string kind;
  for (const char c : without(warning, source)) {
    const bool is_figure = (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+';
    if (!is_figure) kind += c;
  }
  constexpr std::size_t kWords = 3;  // characters; a clause before that is an empty name
  const std::size_t end = kind.find_first_of(",;:`", kWords);
  return kind.substr(0, end);
}

/// Returns the model that most rows recommend, the first of equals; without one the first model of the first row.
std::string common_model_of(const std::vector<Row>& rows) {
  std::vector<std::pair<std::string, std::size_t>> counts;
  for (const Row& row : rows) {
    if (!row.judged || row.recommended == "none") continue;
    const auto found =
        std::find_if(counts.begin(), counts.end(), [&](const auto& count) { return count.first == row.recommended; });
    if (found == counts.end()) {
      counts.emplace_back(row.recommended, 1);
    } else {
      ++found->second;
    }
  }
  const auto most =
      std::max_element(counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (most != counts.end()) return most->first;
  for (const Row& row : rows) {
    if (row.judged && !row.fit.at("models").empty()) return row.fit.at("models").front().at("name");
  }
  return {};
}

/// The reason of one row; empty if it is compared.
std::string why_not_compared(const std::vector<NotCompared>& left_out, std::size_t row) {
  const auto found = std::find_if(left_out.begin(), left_out.end(), [&](const auto& one) { return one.row == row; });
  return found == left_out.end() ? std::string() : found->reason;
}

std::string number(const Json& value) { return value.is_number() ? fmt::format("{}", value.get<double>()) : ""; }

std::vector<std::string> parameter_names(const Table& table) {
  std::vector<std::string> names;
  for (const Row& row : table.rows) {
    if (!row.judged) continue;
    for (const Json& model : row.fit.at("models")) {
      for (const Json& p : model.at("parameters")) {
        const std::string name = p.at("name");
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
    }
  }
  return names;
}

std::string csv_of(const Row& row, const Json& model, const std::vector<std::string>& names, bool is_recommended) {
  const Json verdict = model.value("verdict", Json::object());
  const Json validation = model.value("validation", Json::object());
  std::string line =
      fmt::format("{},{},{},{},{},{},{},{}", record::csv_name(row.record.id), record::csv_name(row.record.source),
                  record::csv_name(model.at("name").get<std::string>()), is_recommended ? "yes" : "no",
                  record::csv_name(verdict.value("word", verdict.value("grade", std::string()))),
                  verdict.value("accepted", false) ? "yes" : "no", number(validation.value("fit_percent", Json())),
                  number(validation.value("r2_percent", Json())));
  for (const std::string& name : names) {
    const Json& parameters = model.at("parameters");
    const auto found =
        std::find_if(parameters.begin(), parameters.end(), [&](const Json& p) { return p.at("name") == name; });
    if (found == parameters.end()) {
      line += ",,,";
    } else {
      line += fmt::format(",{},{},{}", number(found->at("value")), number(found->at("lower95")),
                          number(found->at("upper95")));
    }
  }
  return line + "\n";
}

}  // namespace

namespace {

/// The rows whose model lacks parameters that two thirds of all have, with what it has in their place: a lag may be
/// fitted as a dead time, and would be compared with nothing.
std::map<std::size_t, std::string> lacking_rows(const std::vector<Row>& rows, const std::string& model) {
  constexpr std::size_t kWhole = 3;
  constexpr std::size_t kMost = 2;
  const std::vector<Parameter> parameters = parameters_of(rows, model);
  std::set<std::size_t> all;
  for (const Parameter& parameter : parameters) {
    for (const Estimate& one : parameter.estimates) all.insert(one.row);
  }
  if (all.size() < kFewestForOutliers) return {};
  std::map<std::size_t, std::vector<std::string>> lacking;
  std::map<std::size_t, std::vector<std::string>> instead;
  for (const Parameter& parameter : parameters) {
    std::set<std::size_t> having;
    for (const Estimate& one : parameter.estimates) having.insert(one.row);
    const bool is_usual = kWhole * having.size() >= kMost * all.size();
    for (const std::size_t row : all) {
      if (is_usual && !having.contains(row)) lacking[row].push_back(parameter.name);
      if (!is_usual && having.contains(row)) instead[row].push_back(parameter.name);
    }
  }
  std::map<std::size_t, std::string> found;
  for (const auto& [row, names] : lacking) {
    const auto others = instead.find(row);
    found[row] =
        fmt::format("its {} has {} {}", model,
                    others == instead.end() ? "none" : fmt::format("{} in place", fmt::join(others->second, ", ")),
                    fmt::format("of {}", fmt::join(names, ", ")));
  }
  return found;
}

}  // namespace

std::vector<NotCompared> not_compared(const std::vector<Row>& rows, const std::string& model) {
  std::vector<NotCompared> left_out;
  if (model.empty()) return left_out;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!rows[i].judged) continue;
    const Json* found = model_of(rows[i].fit, model);
    if (found != nullptr && is_accepted(*found)) continue;
    const Json verdict = found == nullptr ? Json::object() : found->at("verdict");
    std::string reason = model + (found == nullptr ? " was not fitted" : " is " + verdict.value("word", "rejected"));
    const Json reasons = verdict.value("reasons", Json());
    const Json* other = model_of(rows[i].fit, rows[i].recommended);
    if (other != nullptr && is_accepted(*other) && (found == nullptr || !(fit_percent(*found) > fit_percent(*other)))) {
      // Another structure follows the record: what is wrong is this one, not the record.
      reason += ", as another structure suits this record: " + rows[i].recommended;
    } else if (reasons.is_array() && !reasons.empty() && reasons.front().is_string()) {
      reason += ": " + ident::statement_of(reasons.front().get<std::string>());
    }
    left_out.push_back({i, std::move(reason)});
  }
  for (auto& [row, reason] : lacking_rows(rows, model)) left_out.push_back({row, std::move(reason), true});
  return left_out;
}

std::string grade_of(const Row& row) {
  const Json* model = model_of(row.fit, row.recommended);
  return model == nullptr ? std::string() : model->at("verdict").value("grade", std::string());
}

std::vector<WarningKind> warning_kinds(const Table& table) {
  struct Kind {
    std::string name;
    std::string text;  ///< of the first record, without its name
    WarningKind found;
    bool differs = false;  ///< in figures, from record to record
  };
  std::vector<Kind> kinds;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::string& source = table.rows[i].record.source;
    for (const std::string& warning : table.rows[i].warnings) {
      const std::string name = kind_of(warning, source);
      const std::string text = without(warning, source);
      auto known = std::find_if(kinds.begin(), kinds.end(), [&](const Kind& one) { return one.name == name; });
      if (known == kinds.end()) known = kinds.insert(kinds.end(), {name, text, {.text = warning, .rows = {}}});
      known->differs = known->differs || text != known->text;
      std::vector<std::size_t>& rows = known->found.rows;
      if (rows.empty() || rows.back() != i) rows.push_back(i);
    }
  }
  std::vector<WarningKind> found;
  for (Kind& kind : kinds) {
    if (kind.differs) {
      kind.found.text +=
          fmt::format(" (figures of {}, the others have their own)", table.rows[kind.found.rows.front()].label);
    }
    found.push_back(std::move(kind.found));
  }
  return found;
}

namespace {

/// The name of the rig of a run; empty where the source is none, or cannot be read any more.
std::string rig_of(const std::string& source) {
  try {
    if (!record::is_run_folder(source)) return {};
    return record::read_manifest(source).other.value(Json::json_pointer("/rig/name"), std::string());
  } catch (const std::exception&) {  // a name that is no text is no Error
    return {};
  }
}

/// A run that a link names by its own path; a file as listed.
std::string resolved(const std::string& source) {
  std::error_code error;
  if (!std::filesystem::is_directory(source, error)) return source;
  const std::filesystem::path own = std::filesystem::canonical(source, error);
  return error ? source : own.string();
}

}  // namespace

std::string rig_units_of(const BatchFolder& folder) {
  std::optional<std::string> units;
  for (const Record& record : folder.batch().records) {
    try {
      if (!record::is_run_folder(record.source)) continue;
      std::string own = record::rig_units(record::read_manifest(record.source).other);
      if (units && *units != own) return {};
      units = std::move(own);
    } catch (const Error&) {
      // Its row says why it cannot be read.
    }
  }
  return units.value_or("");
}

Table table_of(const BatchFolder& folder, const DisplayUnit& unit) {
  Table table;
  for (const Record& record : folder.batch().records) {
    Row row{.record = record,
            .exit_code = 0,
            .judged = false,
            .reason = {},
            .fit = {},
            .recommended = "none",
            .outliers = {}};
    row.rig = rig_of(record.source);
    if (std::optional<Result> result = folder.result(record)) {
      row.exit_code = result->exit_code;
      row.judged = is_judged(*result);
      row.warnings = warnings_in(result->message);
      if (row.judged) {
        show_in(unit, result->fit);
        row.fit = essence_of(result->fit);
        row.recommended = recommended_in(row.fit);
        row.figures = figures_of(result->fit, row.recommended);
        ++table.judged;
      } else {
        row.reason = last_line(result->message);
      }
    } else {
      row.reason = "no result yet";
      ++table.missing;
    }
    table.rows.push_back(std::move(row));
  }
  std::vector<RecordParts> parts;
  for (const Row& row : table.rows) parts.push_back(parts_of(resolved(row.record.source), row.rig));
  const std::vector<std::string> labels = labels_of(parts);
  for (std::size_t i = 0; i < labels.size(); ++i) table.rows[i].label = labels[i];
  table.common_model = common_model_of(table.rows);
  table.resolutions = mark_outliers(table.rows, table.common_model);
  table.trends = trends_of(parameters_of(table.rows, table.common_model));
  return table;
}

std::string to_csv(const Table& table) {
  const std::vector<std::string> names = parameter_names(table);
  std::string text = "record,source,model,recommended,grade,accepted,validation_fit_percent,validation_r2_percent";
  for (const std::string& name : names) {
    for (const char* end : {"", "_lower95", "_upper95"}) text += "," + record::csv_name(name + end);
  }
  text += "\n";
  for (const Row& row : table.rows) {
    if (!row.judged) continue;
    for (const Json& model : row.fit.at("models")) {
      text += csv_of(row, model, names, model.at("name") == row.recommended);
    }
  }
  return text;
}

nlohmann::ordered_json to_json(const Table& table) {
  const std::vector<NotCompared> left_out = not_compared(table.rows, table.common_model);
  Json records = Json::array();
  for (const Row& row : table.rows) {
    Json outliers = Json::array();
    for (const Outlier& one : row.outliers) {
      outliers.push_back(
          {{"parameter", one.parameter}, {"value", one.value}, {"median", one.median}, {"half_width", one.half_width}});
    }
    records.push_back({{"id", row.record.id},
                       {"source", row.record.source},
                       {"judged", row.judged},
                       {"exit_code", row.exit_code},
                       {"reason", row.reason},
                       {"recommended", row.recommended},
                       {"not_compared", why_not_compared(left_out, records.size())},
                       {"outliers", std::move(outliers)},
                       {"warnings", row.warnings},
                       {"fit", row.fit}});
  }
  Json trends = Json::array();
  for (const Trend& one : table.trends) trends.push_back({{"parameter", one.parameter}, {"change", one.change}});
  Json resolutions = Json::array();
  for (const Resolution& one : table.resolutions) {
    resolutions.push_back({{"parameter", one.parameter}, {"smallest_change", one.change}});
  }
  return {{"schema", "eha-batch-table/1"},
          {"records_judged", table.judged},
          {"records_missing", table.missing},
          {"common_model", table.common_model},
          {"outlier_level", kOutlierLevel},
          {"trends", std::move(trends)},
          {"smallest_changes", std::move(resolutions)},
          {"records", std::move(records)}};
}

std::vector<std::filesystem::path> write_table(const BatchFolder& folder, const Table& table) {
  const std::vector<std::filesystem::path> files{folder.path() / "table.csv", folder.path() / "table.json"};
  os::write_file_atomically(files[0], to_csv(table));
  os::write_file_atomically(files[1], to_json(table).dump(2) + "\n");
  return files;
}

}  // namespace eha::batch
