// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/export/model_formats.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cctype>
#include <vector>

#include "core/code_text.hpp"
#include "ident/model/band_text.hpp"
#include "ident/model/parameter_text.hpp"

namespace eha::ident {
namespace {

constexpr std::array kFormats{
    ModelFormat{"octave", "function file for Octave, without packages", &octave_text},
    ModelFormat{"matlab", "the same function file for MATLAB, without toolboxes", &octave_text},
    ModelFormat{"python", "module with one function, needs NumPy alone", &python_text},
    ModelFormat{"c", "C99 source without allocation, one call a row", &c_text},
    ModelFormat{"ss", "state space as matrices A, B, C, D for Octave or MATLAB", &state_space_text},
    ModelFormat{"tf", "transfer function for MATLAB's or Octave's control toolbox", &tf_text},
    ModelFormat{"fmu", "FMI 2.0 for co-simulation, sources inside", &fmu_bytes, true},
    ModelFormat{"json", "state space and lines for FOMCON and CRONE as JSON", &json_text}};

constexpr std::size_t kLongestReason = 200;
constexpr std::size_t kLongestOrigin = 160;

std::string power(const Term& term) {
  if (term.order == 0.0) return fmt::format("{:.6g}", term.coefficient);
  if (term.order == 1.0) return fmt::format("{:.6g} s", term.coefficient);
  return fmt::format("{:.6g} s^{:.6g}", term.coefficient, term.order);
}

std::string sum(const std::vector<Term>& terms) {
  std::string text;
  for (const Term& term : terms) text += (text.empty() ? "" : " + ") + power(term);
  return text;
}

std::string list(const std::vector<Term>& terms, double Term::*member) {
  std::vector<double> values;
  for (const Term& term : terms) values.push_back(term.*member);
  return fmt::format("[{}]", fmt::join(values, " "));
}

/// "NOT NEEDED", which catches the eye in a file of code.
std::string in_capitals(std::string word) {
  for (char& c : word) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return word;
}

/// What an accepted model is good for.
std::string verdict_line(const ExportedModel& model) {
  std::string line = "Verdict: " + model.verdict;
  if (model.largest_error) {
    line += fmt::format("; error on unseen data at most {}",
                        code_text(error_text(*model.largest_error, model.output_unit), kLongestOrigin));
  }
  line += model.usable_band ? "; usable band " + frequencies_text(*model.usable_band) : "; no usable band";
  return line + ".";
}

}  // namespace

std::span<const ModelFormat> model_formats() { return kFormats; }

std::string fomcon_line(const TransferFunction& g) {
  return fmt::format("fotf({}, {}, {}, {}, {})", list(g.denominator, &Term::coefficient),
                     list(g.denominator, &Term::order), list(g.numerator, &Term::coefficient),
                     list(g.numerator, &Term::order), g.delay_s);
}

std::string crone_line(const TransferFunction& g) {
  return fmt::format("frac_tf(frac_poly_exp({}, {}), frac_poly_exp({}, {}))", list(g.numerator, &Term::coefficient),
                     list(g.numerator, &Term::order), list(g.denominator, &Term::coefficient),
                     list(g.denominator, &Term::order));
}

std::vector<std::string> notes(const ExportedModel& model) {
  const TransferFunction& g = model.transfer_function;
  const std::string in = code_text(model.input_unit, 20);
  const std::string out = code_text(model.output_unit, 20);
  std::vector<std::string> lines;
  lines.push_back(
      fmt::format("Model {}: u in {}, y in {}; y = initial_output + G(v), at rest at v = 0 before the first row except "
                  "for the states given.",
                  code_text(model.name, 40), in, out));
  lines.push_back(fmt::format("G(s) = ({}) / ({}), delay {:.6g} s", sum(g.numerator), sum(g.denominator), g.delay_s));
  if (model.input_map) {
    const ValveMap& map = *model.input_map;
    lines.push_back(
        fmt::format("v = 0 for |u - null| <= dead_band, u - null - dead_band above, negative_gain_ratio (u - "
                    "null + dead_band) below; null {:.6g} {}, dead_band {:.6g} {}, negative_gain_ratio {:.6g}",
                    map.null, in, map.dead_band, in, map.negative_gain_ratio));
  } else {
    lines.push_back(fmt::format("v = u + {:.6g} {}", model.input_bias, in));
  }
  lines.emplace_back("u is held between rows, y[k] is just before u[k] takes effect.");
  if (model.error) {
    const ApproximationError& error = *model.error;
    lines.push_back(
        fmt::format("Fractional orders by {} states: at most {:.2g} % and {:.2g} degrees off between {:.4g} and "
                    "{:.4g} Hz; the response to a step is within {:.2g} %, to a multisine within {:.2g} % of its "
                    "peak.",
                    state_space(model.sections).b.size(), error.gain_percent, error.phase_deg, error.band.lowest_Hz,
                    error.band.highest_Hz, error.step_percent, error.multisine_percent));
  } else {
    lines.emplace_back("Whole orders: exact for a held input, up to rounding.");
  }
  for (const std::string& reason : model.rejected_for) {
    lines.push_back(in_capitals(model.verdict) + ": " + code_text(reason, kLongestReason));
  }
  if (model.rejected_for.empty() && !model.verdict.empty()) lines.push_back(verdict_line(model));
  for (const std::string& line : model.origin) lines.push_back(code_text(line, kLongestOrigin));
  lines.push_back("FOMCON: " + fomcon_line(g));
  lines.push_back("CRONE" + std::string(g.delay_s > 0.0 ? " (without the delay): " : ": ") + crone_line(g));
  return lines;
}

}  // namespace eha::ident
