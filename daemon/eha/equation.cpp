// SPDX-License-Identifier: GPL-3.0-or-later
#include "daemon/eha/equation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "daemon/report/html.hpp"

namespace eha::cli {
namespace {

/// Returns a unit after a number; nothing if it is unknown.
std::string behind(const std::string& unit) { return unit.empty() ? "" : " " + unit; }

/// "u + 0.3281 V", or the valve map in words.
std::string driving_text(const ident::Model& model) {
  if (model.input_map) {
    return fmt::format("map(u); map: null {:.4g}{}, half dead band {:.4g}{}, negative gain ratio {:.4g}",
                       model.input_map->null, behind(model.input_unit), model.input_map->dead_band,
                       behind(model.input_unit), model.input_map->negative_gain_ratio);
  }
  if (std::abs(model.input_bias) <= 0.0) return "u";
  return fmt::format("(u {} {:.4g}{})", model.input_bias < 0.0 ? '-' : '+', std::abs(model.input_bias),
                     behind(model.input_unit));
}

}  // namespace

std::string polynomial(const std::vector<ident::Term>& terms, double factor) {
  std::string text;
  for (const ident::Term& term : terms) {
    // With a pole at 0 the constant is absent.
    if (terms.size() > 1 && !(std::abs(term.coefficient) > 0.0)) continue;
    const double value = factor * term.coefficient;
    const double size = std::abs(value);
    text += text.empty() ? (value < 0.0 ? "-" : "") : (value < 0.0 ? " - " : " + ");
    if (!(term.order > 0.0)) {
      text += fmt::format("{:.5g}", size);
    } else {
      if (std::abs(size - 1.0) > 0.0) text += fmt::format("{:.5g} ", size);
      text += std::abs(term.order - 1.0) > 0.0 ? fmt::format("s^{:.5g}", term.order) : "s";
    }
  }
  return text;
}

std::string equation(const ident::Model& model, double factor, const std::string& unit) {
  const ident::TransferFunction& g = model.transfer_function;
  const bool is_one_term = g.numerator.size() == 1;
  const std::string numerator = polynomial(g.numerator, factor);
  const std::string plant = model.grey_box ? std::string(model.grey_box->kind->name) : "G";
  // What a record does not show is no number to print.
  const std::string level = report::reaches_its_offset(model)
                                ? fmt::format("{:.5g}{}", factor * model.initial_output, behind(unit))
                                : std::string("y0");
  std::string text = fmt::format("y = {} + {} {}, {}G = {} / ({})", level, plant, driving_text(model),
                                 model.grey_box ? "linear form " : "", is_one_term ? numerator : "(" + numerator + ")",
                                 polynomial(g.denominator));
  if (g.delay_s > 0.0) text += fmt::format(" exp(-{:.5g} s)", g.delay_s);
  if (!report::reaches_its_offset(model)) text += "; y0: a level that the record does not show, changes of y count";
  if (!model.initial_state.empty() && !model.grey_box)
    text += "; beside it the free response of the record's start (initial state x0, ...)";
  return text;
}

}  // namespace eha::cli
