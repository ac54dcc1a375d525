// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/model_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "daemon/eha/equation.hpp"
#include "daemon/eha/terminal_table.hpp"
#include "ident/model/band_text.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/uncertainty/usable_band.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::cli {
namespace {

using ident::Model;
using ident::ParameterEstimate;
using ident::Score;
using identify::IdentifiedModel;

/// Returns the structure's formula, without the numerator's order if that is held at 0.
std::string formula_of(const ident::StructureOptions& asked) {
  std::string formula = asked.structure.formula;
  const ident::StructureParameter& order = asked.structure.numerator.front().order;
  if (ident::is_estimated(asked, order) || ident::requested(asked, order) > 0.0) return formula;
  const std::string power = " s^" + order.key.name;
  if (const auto at = formula.find(power); at != std::string::npos) formula.erase(at, power.size());
  return formula;
}

std::string orders_text(const Model& model, const ident::Structure& structure) {
  std::vector<std::string> parts;
  for (const ParameterEstimate& parameter : model.parameters) {
    // Whole orders that the structure fixes need no column.
    if (!is_order(parameter.role) || has_finite_state(structure)) continue;
    const bool is_numerator = parameter.role == ident::ParameterRole::numerator_order;
    if (is_numerator && parameter.fixed && !(parameter.value > 0.0)) continue;
    parts.push_back(fmt::format("{} {}", parameter.name, ident::with_interval(parameter)));
  }
  if (parts.empty()) {
    for (const ident::Term& term : model.transfer_function.denominator) parts.push_back(fmt::format("{}", term.order));
  }
  for (const ParameterEstimate& parameter : model.parameters) {
    if (parameter.role == ident::ParameterRole::delay && (!parameter.fixed || parameter.value > 0.0)) {
      parts.push_back(fmt::format("delay {} s", ident::with_interval(parameter)));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void add_score(std::vector<std::string>& row, const std::optional<Score>& score) {
  row.push_back(score ? ident::percent_text(score->r2_percent) : "-");
  row.push_back(score ? fmt::format("{:.3g}", score->mse) : "-");
  row.push_back(score ? ident::percent_text(score->fit_percent) : "-");
}

const char* stability_text(const Model& model) {
  if (!model.stability) return "?";
  if (!model.stability->stable) return "no";
  return model.stability->integrator_order > 0.0 ? "integrates" : "yes";
}

std::vector<std::string> row_for(const IdentifiedModel& identified, const char* mark) {
  const Model& model = identified.result.model;
  std::vector<std::string> row{model.name + mark, formula_of(identified.structure),
                               orders_text(model, identified.structure.structure)};
  add_score(row, model.estimation ? std::optional(model.estimation->score) : std::nullopt);
  add_score(row, model.validation ? std::optional(model.validation->score) : std::nullopt);
  const auto again = model.validation ? model.validation->offset_reestimated : std::nullopt;
  row.push_back(again ? ident::percent_text(again->r2_percent) : "-");
  row.push_back(again ? ident::percent_text(again->fit_percent) : "-");
  row.emplace_back(stability_text(model));
  row.emplace_back(model.verdict ? verdict_word(*model.verdict) : "-");
  row.push_back(model.estimation ? fmt::format("{:.2f}", model.estimation->seconds) : "-");
  return row;
}

/// Writes the map's values, with their intervals if the model lists them.
std::string input_map_text(const Model& model) {
  // An interval takes the structure for the plant's.
  const std::string plus_minus = ident::half_width_sign(model, "+-");
  const auto text = [&](ident::ParameterRole role, double value) {
    const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [&](const ParameterEstimate& parameter) { return parameter.role == role; });
    return at == model.parameters.end() ? fmt::format("{:.4g}", value) : ident::with_interval(*at, plus_minus);
  };
  const ident::ValveMap& map = *model.input_map;
  return fmt::format(", behind a valve: null {} {}, half dead band {} {}, negative gain ratio {}",
                     text(ident::ParameterRole::valve_null, map.null), model.input_unit,
                     text(ident::ParameterRole::dead_band, map.dead_band), model.input_unit,
                     text(ident::ParameterRole::negative_gain_ratio, map.negative_gain_ratio));
}

std::string formula(const Model& model) {
  const ident::TransferFunction& g = model.transfer_function;
  std::string text = fmt::format("({}) / ({})", polynomial(g.numerator), polynomial(g.denominator));
  if (g.delay_s > 0.0) text += fmt::format(" exp(-{:.5g} s)", g.delay_s);
  text += model.input_map ? input_map_text(model)
                          : fmt::format(", input bias {:.4g} {}", model.input_bias, model.input_unit);
  return text + fmt::format(", initial output {:.5g} {}", model.initial_output, model.output_unit);
}

/// Writes the usable band of the model, and whether it includes the resonance.
std::string usable_band_text(const Model& model) {
  if (!model.verdict->usable_band) return "No usable band: " + ident::no_band_text(*model.verdict) + ".";
  const ident::FrequencyInterval& band = *model.verdict->usable_band;
  std::string text = (band.lowest_Hz < band.highest_Hz ? "Usable from " : "Usable at ") + ident::frequencies_text(band);
  const auto peak_Hz = ident::resonance_Hz(model, band);
  const bool inside = peak_Hz && *peak_Hz >= band.lowest_Hz && *peak_Hz <= band.highest_Hz;
  if (inside) return text + fmt::format(", its resonance at {:.3g} Hz included.", *peak_Hz);
  if (peak_Hz) return text + fmt::format("; its resonance at {:.3g} Hz is outside.", *peak_Hz);
  return text + fmt::format("; a resonance above {:.3g} Hz would not show.", band.highest_Hz);
}

std::string notes_on(const IdentifiedModel& identified, const char* mark) {
  const Model& model = identified.result.model;
  const std::string name = model.name + mark;
  std::string text = fmt::format("{}: {}\n", name, formula(model));
  if (const std::string form = ident::engineering_form(model, ident::half_width_sign(model, "+-")); !form.empty())
    text += fmt::format("  {}.\n", form);
  if (model.verdict) {
    for (const std::string& reason : model.verdict->reasons) text += fmt::format("  {}\n", reason);
    if (model.verdict->accepted) text += fmt::format("  {}\n", usable_band_text(model));
  }
  if (!model.estimation) return text;
  if (model.estimation->information) {
    const ident::InformationCriteria& i = *model.estimation->information;
    text += fmt::format("  {} parameters, {} samples: AR-BIC {:.1f} (residual of order {}).\n", i.parameters, i.samples,
                        i.ar_bic, i.ar_order);
  }
  if (model.estimation->correlation && !model.estimation->correlation->indistinguishable.empty()) {
    text += fmt::format("  The record cannot tell these apart: {}.\n",
                        fmt::join(model.estimation->correlation->indistinguishable, ", "));
  }
  return text;
}

}  // namespace

std::string model_report(const std::vector<IdentifiedModel>& models, const std::vector<IdentifiedModel>& paper) {
  const std::string unit = models.empty() || models.front().result.model.output_unit.empty()
                               ? "MSE"
                               : fmt::format("MSE {}^2", models.front().result.model.output_unit);
  const std::vector<Column> columns{
      {"model", Align::left},      {"structure", Align::left}, {"orders +- 95 %", Align::left},
      {"est. R2 %", Align::right}, {unit, Align::right},       {"fit %", Align::right},
      {"val. R2 %", Align::right}, {unit, Align::right},       {"fit %", Align::right},
      {"re. R2 %", Align::right},  {"fit %", Align::right},    {"stable", Align::left},
      {"verdict", Align::left},    {"s", Align::right}};
  std::vector<std::vector<std::string>> rows;
  for (const IdentifiedModel& identified : models) rows.push_back(row_for(identified, ""));
  for (const IdentifiedModel& identified : paper) rows.push_back(row_for(identified, " (paper)"));
  std::string text = text_table(columns, rows);
  text +=
      "+-: half a 95 % interval; est.: estimation part; val.: validation part, offset kept; re.: validation part, "
      "offset re-estimated\n\n";
  for (const IdentifiedModel& identified : models) text += notes_on(identified, "");
  for (const IdentifiedModel& identified : paper) text += notes_on(identified, " (paper)");
  return text;
}

}  // namespace eha::cli
