// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/report/html.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/html_text.hpp"
#include "ident/model/engineering_form.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/verdict.hpp"
#include "ident/validation/verdict_phrases.hpp"

namespace eha::report {
namespace {

using ident::Model;
using ident::ParameterEstimate;

const char* class_of(Column kind) {
  switch (kind) {
    case Column::number:
      return " class=\"number\"";
    case Column::name:
      return " class=\"name\"";
    case Column::id:
      return " class=\"id\"";
    case Column::wide_text:
      return " class=\"wide\"";
    case Column::text:
      break;
  }
  return "";
}

std::string polynomial(const std::vector<ident::Term>& terms) {
  std::string html;
  for (const ident::Term& term : terms) {
    if (terms.size() > 1 && !(std::abs(term.coefficient) > 0.0)) continue;
    const double size = std::abs(term.coefficient);
    const bool negative = term.coefficient < 0.0;
    html += html.empty() ? (negative ? "&minus;" : "") : (negative ? " &minus; " : " + ");
    if (!(term.order > 0.0)) {
      html += fmt::format("{:.5g}", size);
      continue;
    }
    if (std::abs(size - 1.0) > 0.0) html += fmt::format("{:.5g}&nbsp;", size);
    html += std::abs(term.order - 1.0) > 0.0 ? fmt::format("s<sup>{:.5g}</sup>", term.order) : "s";
  }
  return html;
}

/// Writes a stacked fraction; copied as text it is "(a) / (b)".
std::string fraction(const std::string& above, const std::string& below) {
  const auto hidden = [](const char* text) { return fmt::format("<span class=\"hidden\">{}</span>", text); };
  return fmt::format("<span class=\"fraction\">{}<span>{}</span>{}<span>{}</span>{}</span>", hidden("("), above,
                     hidden(") / ("), below, hidden(")"));
}

std::string estimate_or(const Model& model, ident::ParameterRole role, double value) {
  const auto at = std::find_if(model.parameters.begin(), model.parameters.end(),
                               [&](const ParameterEstimate& parameter) { return parameter.role == role; });
  if (at != model.parameters.end() && &*at == ident::unfound_dead_band(model)) {
    return fmt::format("not found, {}", ident::interval_text(*at));
  }
  return at == model.parameters.end() ? fmt::format("{:.4g}", value)
                                      : ident::with_interval(*at, ident::half_width_sign(model, "±"));
}

}  // namespace

bool reaches_its_offset(const Model& model) {
  constexpr double kErrors = 30.0;  // rms, some ten times the greatest error, which a model's file does not hold
  if (!model.estimation) return true;
  const double error = std::sqrt(model.estimation->score.mse);
  return std::none_of(model.parameters.begin(), model.parameters.end(), [&](const ParameterEstimate& p) {
    return p.role == ident::ParameterRole::initial_output && !p.fixed && p.upper95 - p.lower95 > 2.0 * kErrors * error;
  });
}

std::string escaped(std::string_view text) { return escaped_html(text); }

std::string utc_text(std::string text) {
  if (!text.ends_with('Z')) return text;
  text.pop_back();
  std::replace(text.begin(), text.end(), 'T', ' ');
  return text + " UTC";
}

namespace {

/// Text outside of commands: sentences are written for a terminal, with "+-", which begins a word; in names it stays.
std::string prose(std::string_view text) {
  std::string html = escaped(text);
  for (std::size_t at = html.find("+-"); at != std::string::npos; at = html.find("+-", at + 2)) {
    if (at == 0 || html[at - 1] == ' ' || html[at - 1] == '(') html.replace(at, 2, "±");
  }
  return html;
}

/// An id breaks behind its separators, never within a number or a word.
std::string id_html(std::string_view id) {
  std::string html;
  for (const char c : id) {
    html += escaped(std::string_view(&c, 1));
    if (c == '-' || c == '_' || c == '.') html += "<wbr>";
  }
  return html;
}

}  // namespace

std::string with_code(std::string_view text) {
  std::string html;
  while (true) {
    const std::size_t begin = text.find('`');
    const std::size_t end = begin == std::string_view::npos ? begin : text.find('`', begin + 1);
    if (end == std::string_view::npos) return html + prose(text);
    html += prose(text.substr(0, begin)) + "<code>" + escaped(text.substr(begin + 1, end - begin - 1)) + "</code>";
    text.remove_prefix(end + 1);
  }
}

std::string paragraph(std::string_view text) { return "<p>" + with_code(text) + "</p>\n"; }

std::string list(const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string html = "<ul>\n";
  for (const std::string& item : items) html += "<li>" + with_code(item) + "</li>\n";
  return html + "</ul>\n";
}

std::string table(const std::vector<TableColumn>& columns, const std::vector<std::vector<std::string>>& rows) {
  // On a narrow screen each row of a stacked table becomes a block of labelled values.
  constexpr std::size_t kMostBesideEachOther = 4;
  // Short numbers alone fit beside one another.
  const bool has_text =
      std::any_of(columns.begin(), columns.end(), [](const TableColumn& c) { return c.kind != Column::number; });
  const bool is_stacked = has_text && columns.size() > kMostBesideEachOther;
  std::string html = fmt::format("<div class=\"table\"><table{}>\n<thead><tr>", is_stacked ? " class=\"stacked\"" : "");
  for (const TableColumn& column : columns) {
    html += fmt::format("<th scope=\"col\"{}>{}</th>", class_of(column.kind), escaped(column.heading));
  }
  html += "</tr></thead>\n<tbody>\n";
  for (const std::vector<std::string>& row : rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string label =
          is_stacked ? fmt::format(" data-label=\"{}\"", escaped(columns[i].heading)) : std::string();
      html += fmt::format("<td{}{}>{}</td>", class_of(columns[i].kind), label,
                          columns[i].kind == Column::id ? id_html(row[i]) : with_code(row[i]));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string equation(const Model& model) {
  const ident::TransferFunction& g = model.transfer_function;
  std::string html =
      fmt::format("<p class=\"equation\">G(s) = {}", fraction(polynomial(g.numerator), polynomial(g.denominator)));
  if (g.delay_s > 0.0) html += fmt::format(" &middot; e<sup>&minus;{:.4g} s</sup>", g.delay_s);
  if (const std::string form = ident::engineering_form(model, ident::half_width_sign(model, "±")); !form.empty()) {
    html += "<br>" + escaped(form);
  }
  const std::string input_unit = escaped(model.input_unit);
  if (model.input_map) {
    html += fmt::format(
        "<br>behind a valve: null {} {}, half dead band {} {}, negative gain ratio {} (±: half a 95 % "
        "interval{})",
        estimate_or(model, ident::ParameterRole::valve_null, model.input_map->null), input_unit,
        estimate_or(model, ident::ParameterRole::dead_band, model.input_map->dead_band), input_unit,
        estimate_or(model, ident::ParameterRole::negative_gain_ratio, model.input_map->negative_gain_ratio),
        model.verdict && may_miss_a_part(*model.verdict)
            ? ", of noise alone; at least, as a part of the plant that the model misses adds an error of its own"
            : "");
  } else {
    html += fmt::format("<br>input bias {:.4g} {}", model.input_bias, input_unit);
  }
  const std::string output_unit = escaped(model.output_unit);
  if (model.initial_state.empty() && reaches_its_offset(model)) {
    return html + fmt::format("<br>initial output {:.5g} {}</p>\n", model.initial_output, output_unit);
  }
  // The offset lies where the free response ends, which may be long after the record, and far from where the output can
  // be.
  if (!reaches_its_offset(model)) {
    return html + (model.initial_state.empty()
                       ? "<br>a level that the record does not show: changes of the output count</p>\n"
                       : "<br>a free response whose end the record does not show</p>\n");
  }
  return html + fmt::format("<br>a free response that ends at {} {}</p>\n",
                            estimate_or(model, ident::ParameterRole::initial_output, model.initial_output),
                            output_unit);
}

}  // namespace eha::report
