// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "daemon/plot/envelope.hpp"
#include "daemon/report/figures.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::report {
namespace {

using ident::Model;

/// "0.0132 s"; 0 for a parameter that the model does not have.
std::string with_unit(const Model& model, const char* name) {
  const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                               [&](const ident::ParameterEstimate& parameter) { return parameter.name == name; });
  if (at == model.parameters.end()) return "0";
  const std::string unit = ident::unit_of(*at, model);
  return fmt::format("{:.5g}{}{}", at->value, unit.empty() ? "" : " ", unit);
}

std::string parameter_table(const std::vector<Model>& models) {
  constexpr const char* kNames[] = {"K", "a2", "a1", "a0", "n2", "n1", "n0", "b0"};
  std::vector<TableColumn> columns{{"model"}};
  for (const char* name : kNames) columns.push_back({name, Column::number});
  std::vector<std::vector<std::string>> rows;
  for (const Model& model : models) {
    std::vector<std::string> row{model.name};
    for (const char* name : kNames) row.push_back(with_unit(model, name));
    rows.push_back(std::move(row));
  }
  return table(columns, rows);
}

std::string score_table(const std::vector<Model>& models) {
  std::string unit;
  std::vector<std::vector<std::string>> rows;
  for (const Model& model : models) {
    if (!model.validation) continue;
    const ident::Score& score = model.validation->score;
    unit = model.output_unit;
    rows.push_back({model.name, ident::percent_text(score.r2_percent), fmt::format("{:.3g}", score.mse),
                    ident::error_figure(score.error_min), ident::error_figure(score.error_max),
                    !model.stability          ? "unknown"
                    : model.stability->stable ? "yes"
                                              : "no"});
  }
  return table({{"model"},
                {"R2 %", Column::number},
                {fmt::format("MSE [{}^2]", unit), Column::number},
                {fmt::format("least error [{}]", unit), Column::number},
                {fmt::format("greatest error [{}]", unit), Column::number},
                {"stable"}},
               rows);
}

/// One panel: the measured and the simulated output, or a residual alone.
plot::Figure output_figure(const identify::FitTable& table, const identify::FitColumn& column) {
  plot::Panel panel{.x_label = "time [s]", .y_label = axis_label(table.output)};
  plot::Points measured = plot::envelope(table.time_s, table.measured);
  plot::Points simulated = plot::envelope(table.time_s, column.simulated);
  panel.series.push_back({.label = "measured", .x = measured.x, .y = measured.y, .mark = plot::Mark::line, .style = 0});
  panel.series.push_back({.label = column.model + " by the paper's procedure",
                          .x = simulated.x,
                          .y = simulated.y,
                          .mark = plot::Mark::line,
                          .style = 1});
  return {.title = "Output of " + column.model + " by the paper's procedure", .panels = {std::move(panel)}};
}

plot::Figure error_figure(const identify::FitTable& table) {
  plot::Panel panel{.x_label = "time [s]", .y_label = axis_label({"error, measured - model", table.output.unit})};
  int style = 1;
  for (const identify::FitColumn& column : table.models) {
    std::vector<double> error(table.measured.size());
    std::transform(table.measured.begin(), table.measured.end(), column.simulated.begin(), error.begin(),
                   std::minus<>());
    plot::Points points = plot::envelope(table.time_s, error);
    panel.series.push_back(
        {.label = column.model, .x = points.x, .y = points.y, .mark = plot::Mark::line, .style = style++});
  }
  panel.rules.push_back({.at = 0.0, .vertical = false});
  return {.title = "Errors by the paper's procedure", .panels = {std::move(panel)}};
}

plot::Figure record_of(const identify::FitTable& table) {
  plot::Points u = plot::envelope(table.time_s, table.applied);
  plot::Points y = plot::envelope(table.time_s, table.measured);
  plot::Panel input{.x_label = "", .y_label = axis_label(table.input)};
  input.series.push_back({.label = "input", .x = u.x, .y = u.y, .mark = plot::Mark::line, .style = 1});
  plot::Panel output{.x_label = "time [s]", .y_label = axis_label(table.output)};
  output.series.push_back({.label = "output", .x = y.x, .y = y.y, .mark = plot::Mark::line, .style = 1});
  return {.title = "The samples that the paper's procedure keeps", .panels = {std::move(input), std::move(output)}};
}

/// Whether a model of the table has a finite value to draw.
bool is_drawable(const identify::FitColumn& column) {
  return std::any_of(column.simulated.begin(), column.simulated.end(), [](double y) { return std::isfinite(y); });
}

/// The validation R2 of the model of the same name by the default procedure.
std::string comparison(const Subject& subject, const Model& model) {
  for (const ReportedModel& reported : subject.models) {
    if (reported.model.name == model.name && reported.model.validation && model.validation) {
      return fmt::format("{}: R2 {} % by the paper's procedure, {} % by the default one. ", model.name,
                         ident::percent_text(model.validation->score.r2_percent),
                         ident::percent_text(reported.model.validation->score.r2_percent));
    }
  }
  return model.validation
             ? fmt::format("{}: R2 {} %. ", model.name, ident::percent_text(model.validation->score.r2_percent))
             : "";
}

double range_of(const std::vector<double>& values) {
  const auto [least, greatest] = std::minmax_element(values.begin(), values.end());
  return *greatest - *least;
}

Remark on_record(const identify::FitTable& table) {
  return {
      .seen = fmt::format("{} kept samples from {:.4g} to {:.4g} s; the input moves over {:.3g} {}, the output over "
                          "{:.3g} {}.",
                          table.time_s.size(), table.time_s.front(), table.time_s.back(), range_of(table.applied),
                          table.input.unit, range_of(table.measured), table.output.unit),
      .good = "The output moves through a large part of the travel, the input stays within +-5 V.",
      .to_do = "Nothing."};
}

Remark on_output(const Subject& subject, const std::string& name) {
  const auto at =
      std::find_if(subject.paper.begin(), subject.paper.end(), [&](const Model& model) { return model.name == name; });
  Remark remark{.seen = at != subject.paper.end() ? comparison(subject, *at) : "",
                .good =
                    "The lines cover each other. The paper printed R2 82.35 % for IO and 88.68 % for FO, on its own "
                    "rig.",
                .to_do =
                    "Use it to compare with the paper, and the models above for everything else: this procedure "
                    "estimates neither bias nor initial state, and holds the input between kept samples."};
  if (at != subject.paper.end() && at->stability && !at->stability->stable) {
    remark.seen +=
        "It is unstable: a finer simulation of it grows. Only the coarse differences of the paper's procedure, from "
        "one kept sample to the next, and the new start of each half keep this output finite.";
  }
  return remark;
}

Remark on_errors(const identify::FitTable& table) {
  Remark remark{.seen = {},
                .good = "No slope, no oscillation at the input's frequencies, no jump in the middle.",
                .to_do =
                    "The restart of the second half causes a jump in the middle, the missing bias a slope: the default "
                    "procedure has neither."};
  for (const identify::FitColumn& column : table.models) {
    double greatest = 0.0;
    for (std::size_t i = 0; i < table.measured.size(); ++i) {
      const double error = std::abs(table.measured[i] - column.simulated[i]);
      if (error > greatest) greatest = error;
    }
    remark.seen +=
        fmt::format("Largest error of {}: {}. ", column.model, ident::error_text(greatest, table.output.unit));
  }
  return remark;
}

Remark on_correlation(const ident::ValidationReport& validation) {
  return {
      .seen = fmt::format("{} of {} lags of the residual with itself and {} of {} with the input at lags 0 and more "
                          "lie outside the 99 % bound.",
                          outside99(validation.acf, 1), validation.acf.lags.size() - 1, outside99(validation.ccf, 0),
                          validation.ccf.lags.size() / 2 + 1),
      .good = "All stems within the bounds.",
      .to_do = "Nothing here; see the residual of the recommended model above."};
}

Remark on_stability(const Model& model) {
  const bool is_stable = model.stability && model.stability->stable;
  return {.seen = fmt::format("{} is {}.", model.name, is_stable ? "stable" : "not stable"),
          .good = "No cross within the shaded sector.",
          .to_do = is_stable ? "Nothing." : "Do not use this model: the procedure took drift or bias for dynamics."};
}

}  // namespace

Section paper_section(const Subject& subject) {
  Section section{.title = "The paper's procedure"};
  if (subject.paper.empty()) return section;
  Item tables{.heading = ""};
  tables.html = paragraph(
      "The published procedure to the letter, for comparison: every kept sample of the record after the discarded "
      "time, the first half estimates and the second validates, each from zero history. The figures follow figures 5 "
      "to 11 of the paper: record, output of each model, errors, correlations, stability.");
  tables.html += "<h3>Parameters (table 1 of the paper)</h3>\n" + parameter_table(subject.paper);
  tables.html += "<h3>Validation (table 2 of the paper)</h3>\n" + score_table(subject.paper);
  section.items.push_back(std::move(tables));
  const identify::FitTable& fit = subject.paper_fit;
  if (!fit.time_s.empty()) {
    section.items.push_back({.heading = "Record", .figure = record_of(fit), .remark = on_record(fit)});
    for (const identify::FitColumn& column : fit.models) {
      if (!is_drawable(column)) continue;
      section.items.push_back({.heading = "Measured and simulated output, " + column.model,
                               .figure = output_figure(fit, column),
                               .remark = on_output(subject, column.model)});
    }
    section.items.push_back({.heading = "Errors", .figure = error_figure(fit), .remark = on_errors(fit)});
  }
  for (const Model& model : subject.paper) {
    if (!model.validation || model.validation->acf.lags.empty() || model.validation->ccf.lags.empty()) continue;
    const std::string heading = "Correlation of the residual, " + model.name;
    section.items.push_back(
        {.heading = heading,
         .figure = plot::Figure{.title = heading,
                                .panels = {correlation_panel(model.validation->acf, "with itself"),
                                           correlation_panel(model.validation->ccf, "with the input")}},
         .remark = on_correlation(*model.validation)});
  }
  for (const Model& model : subject.paper) {
    section.items.push_back(
        {.heading = "Stability, " + model.name, .figure = pole_figure(model), .remark = on_stability(model)});
  }
  return section;
}

}  // namespace eha::report
