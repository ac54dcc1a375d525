// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/report/advice.hpp"
#include "daemon/report/html.hpp"
#include "daemon/report/section.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_name.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::report {
namespace {

using ident::Model;
using ident::ParameterEstimate;

constexpr double kWide_percent = 50.0;        // half width above which an interval is uninformative
constexpr double kMostShown_percent = 200.0;  // the axis ends so far from the value
constexpr double kLeastShown_percent = 1.0;   // it shows at least so much on either side
constexpr std::size_t kMostTables = 3;

bool is_estimated(const ParameterEstimate& parameter) {
  return !parameter.fixed && std::abs(parameter.std) > 0.0 && std::abs(parameter.value) > 0.0;
}

/// Ends of the 95 % interval in percent of the estimate.
std::pair<double, double> interval_percent(const ParameterEstimate& parameter) {
  const double a = 100.0 * parameter.lower95 / parameter.value;
  const double b = 100.0 * parameter.upper95 / parameter.value;
  return {std::min(a, b), std::max(a, b)};
}

plot::Figure interval_figure(const Model& model, const std::vector<const ParameterEstimate*>& parameters) {
  plot::Panel panel{.x_label = "", .y_label = "95 % interval [% of the value]"};
  plot::Series bars{.label = "", .mark = plot::Mark::error_bars, .style = 1};
  double reach = kLeastShown_percent;
  for (const ParameterEstimate* parameter : parameters) {
    const auto [lower, upper] = interval_percent(*parameter);
    const double x = static_cast<double>(bars.x.size()) + 1.0;
    bars.x.push_back(x);
    bars.y.push_back(100.0);
    // An unbounded interval extends beyond the plot.
    const auto drawn = [](double value, double end) { return std::isfinite(value) ? value : end; };
    bars.lower.push_back(std::max(drawn(lower, -1e3), -1e3));
    bars.upper.push_back(std::min(drawn(upper, 1e3), 1e3));
    reach = std::max({reach, 100.0 - bars.lower.back(), bars.upper.back() - 100.0});
    panel.x_ticks.push_back({.at = x, .text = ident::shown_name(parameter->role, parameter->name)});
  }
  panel.x_range = std::pair(0.5, static_cast<double>(parameters.size()) + 0.5);
  reach = 1.1 * std::min(reach, kMostShown_percent);
  panel.y_range = std::pair(100.0 - reach, 100.0 + reach);
  panel.rules = {{.at = 100.0, .vertical = false}, {.at = 0.0, .vertical = false}};
  panel.series.push_back(std::move(bars));
  return {.title = "95 % intervals of the parameters of " + model.name, .panels = {std::move(panel)}};
}

Remark remark_on(const Subject& subject, const Model& model, const std::vector<const ParameterEstimate*>& parameters) {
  std::vector<std::string> may_be_0;
  std::vector<std::string> wide;
  for (const ParameterEstimate* parameter : parameters) {
    const auto [lower, upper] = interval_percent(*parameter);
    if (!(lower > 0.0)) {
      may_be_0.push_back(parameter->name);
    } else if (!(upper - lower < 2.0 * kWide_percent)) {
      wide.push_back(parameter->name);
    }
  }
  Remark remark;
  if (may_be_0.empty() && wide.empty()) {
    remark.seen = fmt::format("All {} estimated parameters of {} are known to {:.0f} % or better, and none may be 0.",
                              parameters.size(), model.name, kWide_percent);
  }
  if (!may_be_0.empty()) {
    remark.seen += fmt::format("The record does not exclude that {} of {} {} 0.", fmt::join(may_be_0, ", "), model.name,
                               may_be_0.size() == 1 ? "is" : "are");
  }
  if (!wide.empty()) {
    remark.seen += fmt::format("{}Known to worse than {:.0f} %: {}.", may_be_0.empty() ? "" : " ", kWide_percent,
                               fmt::join(wide, ", "));
  }
  const bool is_cut = std::any_of(parameters.begin(), parameters.end(), [](const ParameterEstimate* parameter) {
    const auto [lower, upper] = interval_percent(*parameter);
    return !(std::max(100.0 - lower, upper - 100.0) <= kMostShown_percent);
  });
  remark.good =
      fmt::format("Bars of a few per cent. {}; a bar that reaches 0 % is a parameter that may be 0.",
                  is_cut ? "A bar that leaves the axis is longer than it" : "The axis ends with the longest one");
  remark.to_do =
      may_be_0.empty() && wide.empty()
          ? nothing_to_do(subject)
          : "If you need these parameters, excite where they act: high frequencies for a2 and delays, slow "
            "tones and a longer record for a0 and input_bias. If not, a model without them predicts as well.";
  return remark;
}

/// A number with the digits that two digits of its standard error justify.
std::string justified(double value, double std) {
  if (!std::isfinite(value)) return "none";
  const bool has_decimals = std >= 1e-8 && std < 100.0;
  return has_decimals ? ident::rounded_to(value, std) : fmt::format("{:.5g}", value);
}

std::string parameter_table(const Model& model) {
  std::vector<std::vector<std::string>> rows;
  for (const ParameterEstimate& parameter : model.parameters) {
    const std::string unit = ident::unit_of(parameter, model);
    const std::string name = ident::shown_name(parameter.role, parameter.name);
    const double std = parameter.std;
    if (parameter.fixed) {
      rows.push_back({name, fmt::format("{:.6g}", parameter.value), unit, "held", "", ""});
    } else if (std > 0.0) {
      rows.push_back({name, justified(parameter.value, std), unit, justified(std, std),
                      justified(parameter.lower95, std), justified(parameter.upper95, std)});
    } else {
      rows.push_back({name, fmt::format("{:.6g}", parameter.value), unit, "not known", "", ""});
    }
  }
  const bool is_least = model.verdict && may_miss_a_part(*model.verdict);
  return table({{"parameter"},
                {"value", Column::number},
                {"unit"},
                {is_least ? "standard error, at least" : "standard error", Column::number},
                {is_least ? "lower 95 %, at most" : "lower 95 %", Column::number},
                {is_least ? "upper 95 %, at least" : "upper 95 %", Column::number}},
               rows) +
         (is_least ? paragraph("At least, at most: by noise alone. A part of the plant that the model may miss adds an "
                               "error of its own to every value.")
                   : std::string());
}

/// Where the equation has the parameters, and their names in files.
std::string names_paragraph(const Model& model) {
  const auto& below = model.transfer_function.denominator;
  const auto has = [&](double order) {
    return std::any_of(below.begin(), below.end(), [&](const ident::Term& term) {
      return std::abs(term.order - order) < 1e-9 && std::abs(term.coefficient) > 0.0;
    });
  };
  std::string text;
  if (below.size() <= 3 && has(2.0) && has(1.0) && !has(0.0)) text = "T of the equation is a2. ";
  if (model.input_map) text += "The half dead band goes from the null to an edge; in files it is dead_band.";
  return text.empty() ? std::string() : paragraph(text);
}

}  // namespace

Section parameter_section(const Subject& subject) {
  Section section{.title = "Parameters"};
  for (const ReportedModel& reported : subject.models) {
    const Model& model = reported.model;
    if (section.items.size() == kMostTables || model.parameters.empty()) break;
    Item item{.heading = "Parameters of " + model.name};
    item.html = parameter_table(model);
    item.html += names_paragraph(model);
    std::vector<const ParameterEstimate*> estimated;
    for (const ParameterEstimate& parameter : model.parameters) {
      if (is_estimated(parameter)) estimated.push_back(&parameter);
    }
    if (section.items.empty() && !estimated.empty()) {
      item.figure = interval_figure(model, estimated);
      item.remark = remark_on(subject, model, estimated);
    }
    section.items.push_back(std::move(item));
  }
  return section;
}

}  // namespace eha::report
