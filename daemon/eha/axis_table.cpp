// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/axis_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <set>

#include "core/error.hpp"
#include "daemon/eha/model_argument.hpp"
#include "daemon/record/csv_field.hpp"
#include "daemon/record/sha256.hpp"
#include "daemon/sheet/run_sheet.hpp"
#include "daemon/tune/controller_page.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/validation/output_unit.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::cli {
namespace {

constexpr std::size_t kCells = 9;
using Row = std::array<std::string, kCells>;

/// Writes a cell for spreadsheets: a name is never a formula.
std::string cell(std::string text) {
  double number = 0.0;
  const char* end = text.data() + text.size();
  const bool is_number = std::from_chars(text.data(), end, number).ptr == end;
  if (!is_number && text.find_first_of("=+-@") == 0) text.insert(0, 1, '\'');
  return record::csv_field(text);
}

/// Settings that belong to the valve.
bool is_of_valve(const std::string& setting) {
  static const std::set<std::string> kNames{"null", "half dead band", "gain extending", "gain retracting"};
  return kNames.contains(setting);
}

}  // namespace

std::string axis_table(const AxisTable& table, const DisplayUnit& unit) {
  const config::ControllerConfig& c = table.controller;
  std::vector<Row> rows{
      {"part", "figure", "value", "from", "to", "measured", "noise adds to", "unit", "kept"},
      {"axis", "controller", c.name},
      {"axis", "rig", c.provenance.rig},
      {"axis", "run", c.provenance.run},
      {"axis", "valve sheet", c.provenance.sheet.empty() ? "none" : c.provenance.sheet},
      {"axis", "trial",
       c.promise.twins > 0 ? fmt::format("{} drawn rigs ({})", c.promise.twins, c.provenance.twin) : ""},
      {"axis", "made by", c.provenance.made_by}};
  if (table.model) {
    const ident::Model& model = *table.model;
    rows.push_back({"model", "name", model.name});
    const std::string form = ident::engineering_form(in_unit(model, unit));
    if (!form.empty()) rows.push_back({"model", "in figures", form});
    if (model.validation) {
      rows.push_back({"model", "fit on unseen data", fmt::format("{:.1f}", model.validation->score.fit_percent), "", "",
                      "", "", "%"});
    }
    if (model.verdict) rows.push_back({"model", "verdict", std::string(ident::verdict_word(*model.verdict))});
  }
  if (table.sheet) {
    const auto row = [&](const char* what, const std::optional<ident::Measured>& m, const char* of) {
      if (!m) return;
      const double factor = unit.factor(of);
      const auto number = [&](double value) { return fmt::format("{:.4g}", factor * value); };
      rows.push_back({"valve, measured", what, number(m->value), number(m->value - m->half_width),
                      number(m->value + m->half_width), "", "", unit.of(of)});
    };
    const ident::ValveSheet& sheet = *table.sheet;
    row("null", sheet.null_V, "V");
    row("half dead band", sheet.dead_band_V, "V");
    row("gain extending", sheet.gain_positive_in_per_V_s, "in/(V s)");
    row("gain retracting", sheet.gain_negative_in_per_V_s, "in/(V s)");
    rows.push_back({"valve, measured", "sensor noise, RMS", fmt::format("{:.3g}", sheet.noise_in * unit.factor("in")),
                    "", "", "", "", unit.of("in")});
  }
  const std::vector<std::vector<std::string>> settings = tune::setting_rows(c, unit);
  for (const bool valve : {true, false}) {
    for (const auto& setting : settings) {
      if (is_of_valve(setting[0]) != valve) continue;
      rows.push_back({valve ? "valve, as used" : "controller", setting[0], setting[1], "", "", "", "", setting[2]});
    }
  }
  for (const auto& figure : tune::promise_rows(c.promise, unit)) {
    Row row{"promise", figure[0], figure[1], figure[2], figure[3], "", "", figure[4]};
    const auto found = std::find_if(table.measured.begin(), table.measured.end(),
                                    [&](const track::KeptFigure& f) { return f.name == figure[0]; });
    if (found != table.measured.end()) {
      row[5] = fmt::format("{:.3g}", found->measured * unit.factor(found->unit));
      row[6] = fmt::format("{:.2g}", found->noise * unit.factor(found->unit));
      row[8] = track::kept_text(*found);
    } else if (!table.measured.empty()) {
      row[8] = "not measured";
    }
    rows.push_back(std::move(row));
  }
  std::string text;
  for (Row& row : rows) {
    for (std::string& value : row) value = cell(std::move(value));
    text += fmt::format("{}\n", fmt::join(row, ","));
  }
  return text;
}

std::optional<ident::Model> model_of(const config::ControllerConfig& controller) {
  try {
    if (record::sha256_of_file(controller.provenance.model) != controller.provenance.model_sha256) return std::nullopt;
    return read_model(controller.provenance.model);
  } catch (const Error&) {  // the file no longer exists
    return std::nullopt;
  }
}

std::optional<ident::ValveSheet> sheet_of(const config::ControllerConfig& controller) {
  if (controller.provenance.sheet.empty()) return std::nullopt;
  try {
    return sheet::sheet_of_run(controller.provenance.sheet).sheet;
  } catch (const Error&) {  // the run no longer exists
    return std::nullopt;
  }
}

}  // namespace eha::cli
