// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "core/code_text.hpp"
#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

constexpr double kShortestStep_s = 1e-4;  // the delay's buffer suffices down to this step unless it is made longer
constexpr double kLongestBuffer = 1e6;

// The words in capitals are replaced, here and nowhere else in the file; braces stay C's own.
constexpr const char* kDeclarations = R"(
enum { NAME_SECTIONS = COUNT, NAME_ORDER = HIGHEST };
#ifndef NAME_DELAY_ROWS
#define NAME_DELAY_ROWS BUFFER /* rows of input that the delay keeps: delay / step + 2 at least */
#endif

typedef struct {
  double a[NAME_SECTIONS][NAME_ORDER][NAME_ORDER];
  double before[NAME_SECTIONS][NAME_ORDER];
  double now[NAME_SECTIONS][NAME_ORDER];
  double x[NAME_SECTIONS][NAME_ORDER];
  double past[NAME_DELAY_ROWS];
  int length; /* of `past` in use */
  int at;
} FUNCTION_model;

/* Prepares a model for rows step_s seconds apart, at the start of a record. Returns 0, or -1 when step_s is not positive
   or NAME_DELAY_ROWS is too small for it. */
int FUNCTION_init(FUNCTION_model *model, double step_s);
/* The output of this row, then moves on with the input held until the next one. */
double FUNCTION_step(FUNCTION_model *model, double INPUT_NAME);
)";

constexpr const char* kFunctions = R"(
enum { NAME_SIZE = NAME_ORDER + 1 };

/* m = m m2 */
static void FUNCTION_multiply(double m[NAME_SIZE][NAME_SIZE], double m2[NAME_SIZE][NAME_SIZE]) {
  double row[NAME_SIZE];
  double right[NAME_SIZE][NAME_SIZE];
  int i, j, k;
  for (i = 0; i < NAME_SIZE; ++i) {
    for (j = 0; j < NAME_SIZE; ++j) right[i][j] = m2[i][j];
  }
  for (i = 0; i < NAME_SIZE; ++i) {
    for (j = 0; j < NAME_SIZE; ++j) {
      row[j] = 0.0;
      for (k = 0; k < NAME_SIZE; ++k) row[j] += m[i][k] * right[k][j];
    }
    for (j = 0; j < NAME_SIZE; ++j) m[i][j] = row[j];
  }
}

/* exp([A b; 0 0] duration) of a section by scaling, Taylor series and squaring. */
static void FUNCTION_exponential(int section, double duration_s, double result[NAME_SIZE][NAME_SIZE]) {
  double m[NAME_SIZE][NAME_SIZE];
  double norm = 0.0;
  double scale = FUNCTION_rate[section] * duration_s;
  int squarings = 0;
  int i, j, k;
  for (i = 0; i < NAME_SIZE; ++i) {
    double sum = 0.0;
    for (j = 0; j < NAME_SIZE; ++j) m[i][j] = 0.0;
    if (i < FUNCTION_order[section]) {
      m[i][0] = -FUNCTION_denominator[section][i];
      if (i + 1 < FUNCTION_order[section]) m[i][i + 1] = 1.0;
      m[i][NAME_ORDER] = FUNCTION_numerator[section][i];
    }
    for (j = 0; j < NAME_SIZE; ++j) sum += fabs(m[i][j]);
    if (sum > norm) norm = sum;
  }
  for (norm *= scale; norm > 0.5; norm *= 0.5) {
    scale *= 0.5;
    ++squarings;
  }
  for (i = 0; i < NAME_SIZE; ++i) {
    for (j = 0; j < NAME_SIZE; ++j) result[i][j] = i == j ? 1.0 : 0.0;
  }
  for (k = 14; k >= 1; --k) {
    double product[NAME_SIZE][NAME_SIZE];
    for (i = 0; i < NAME_SIZE; ++i) {
      for (j = 0; j < NAME_SIZE; ++j) product[i][j] = m[i][j] * scale / k;
    }
    FUNCTION_multiply(product, result);
    for (i = 0; i < NAME_SIZE; ++i) {
      for (j = 0; j < NAME_SIZE; ++j) result[i][j] = product[i][j] + (i == j ? 1.0 : 0.0);
    }
  }
  for (k = 0; k < squarings; ++k) FUNCTION_multiply(result, result);
}

int FUNCTION_init(FUNCTION_model *model, double step_s) {
  double samples, whole, late_s = 0.0;
  int i, j, s;
  if (!(step_s > 0.0)) return -1;
  samples = FUNCTION_delay_s / step_s;
  whole = floor(samples);
  if (samples - whole > 1.0 - 1e-9) whole += 1.0;
  if (samples - whole > 1e-9) late_s = FUNCTION_delay_s - whole * step_s;
  if (whole + 2.0 > (double)NAME_DELAY_ROWS) return -1;
  model->length = (int)whole + 2;
  model->at = 0;
  for (i = 0; i < model->length; ++i) model->past[i] = 0.0;
  for (s = 0; s < NAME_SECTIONS; ++s) {
    double all[NAME_SIZE][NAME_SIZE], first[NAME_SIZE][NAME_SIZE], rest[NAME_SIZE][NAME_SIZE];
    FUNCTION_exponential(s, step_s, all);
    FUNCTION_exponential(s, late_s, first);
    FUNCTION_exponential(s, step_s - late_s, rest);
    for (i = 0; i < NAME_ORDER; ++i) {
      model->before[s][i] = 0.0;
      for (j = 0; j < NAME_ORDER; ++j) {
        model->a[s][i][j] = all[i][j];
        model->before[s][i] += rest[i][j] * first[j][NAME_ORDER];
      }
      model->now[s][i] = rest[i][NAME_ORDER];
      model->x[s][i] = FUNCTION_state[s][i];
    }
  }
  return 0;
}

double FUNCTION_step(FUNCTION_model *model, double INPUT_NAME) {
  const int length = model->length;
  double v, before, now, output;
  int i, j, s;
DRIVING
  model->past[model->at] = v;
  before = model->past[(model->at + 1) % length];
  now = model->past[(model->at + 2) % length];
  model->at = (model->at + 1) % length;
  output = FUNCTION_initial_output + FUNCTION_direct * before;
  for (s = 0; s < FUNCTION_count; ++s) {
    const int order = FUNCTION_order[s];
    double x[NAME_ORDER] = {0.0};
    output += model->x[s][0];
    for (i = 0; i < order; ++i) {
      x[i] = model->before[s][i] * before + model->now[s][i] * now;
      for (j = 0; j < order; ++j) x[i] += model->a[s][i][j] * model->x[s][j];
    }
    for (i = 0; i < order; ++i) model->x[s][i] = x[i];
  }
  return output;
}
)";

using Replacement = std::pair<std::string_view, std::string>;

/// The values are not searched: a name may contain one of the words.
std::string filled(std::string_view text, const std::vector<Replacement>& replacements) {
  std::string result;
  while (!text.empty()) {
    const auto begins = [&](const Replacement& r) { return text.starts_with(r.first); };
    const auto found = std::find_if(replacements.begin(), replacements.end(), begins);
    result += found == replacements.end() ? text.substr(0, 1) : std::string_view(found->second);
    text.remove_prefix(found == replacements.end() ? 1 : found->first.size());
  }
  return result;
}

/// C takes `1` for an integer.
std::string number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string table(const std::vector<Section>& sections, std::size_t order, std::vector<double> Section::*member) {
  std::string text;
  for (const Section& section : sections) {
    std::vector<std::string> row;
    for (const double value : section.*member) row.push_back(number(value));
    row.resize(order, "0.0");
    text += fmt::format("  {{{}}},\n", fmt::join(row, ", "));
  }
  return text;
}

}  // namespace

std::string c_text(const ExportedModel& model, const std::string& function) {
  std::vector<Section> sections = model.sections.list;
  const std::size_t count = sections.size();
  if (sections.empty()) sections.push_back({1.0, {0.0}, {0.0}, {0.0}});  // C has no empty arrays
  std::size_t order = 1;
  for (const Section& section : sections) order = std::max(order, section.denominator.size());
  std::string name = function;
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::toupper(c); });

  const std::string input = with_unit("u", model.input_unit);
  const std::string output = with_unit("y", model.output_unit);
  std::string text = "/*\n";
  for (const std::string& line : notes(model)) text += " * " + line + "\n";
  text += fmt::format(
      " *\n * C99, no allocation, no library but libm; include this file, or compile it and copy the declarations:\n"
      " *   {0}_model model;\n *   if ({0}_init(&model, 0.001) == 0) {1} = {0}_step(&model, {2});\n "
      "*/\n#include <math.h>\n",
      function, output, input);
  const double buffer = std::min(kLongestBuffer, std::ceil(model.sections.delay_s / kShortestStep_s) + 2.0);
  text += filled(kDeclarations, {{"COUNT", std::to_string(sections.size())},
                                 {"HIGHEST", std::to_string(order)},
                                 {"BUFFER", fmt::format("{:.0f}", buffer)},
                                 {"INPUT_NAME", input},
                                 {"NAME_", name + "_"},
                                 {"FUNCTION_", function + "_"}});
  text += fmt::format("\nstatic const int {}_count = {};\n", function, count);
  const auto scalar = [&](const char* what, double value) {
    text += fmt::format("static const double {}_{} = {};\n", function, what, number(value));
  };
  scalar("direct", model.sections.direct);
  scalar("delay_s", model.sections.delay_s);
  scalar("initial_output", model.initial_output);
  std::vector<std::size_t> orders;
  std::vector<std::string> rates;
  for (const Section& section : sections) {
    orders.push_back(section.denominator.size());
    rates.push_back(number(section.rate_rad_s));
  }
  text += fmt::format("static const int {}_order[{}_SECTIONS] = {{{}}};\n", function, name, fmt::join(orders, ", "));
  text += "/* rad/s */\n";
  text += fmt::format("static const double {}_rate[{}_SECTIONS] = {{{}}};\n", function, name, fmt::join(rates, ", "));
  text += "/* below the highest power of s / rate */\n";
  const auto matrix = [&](const char* what, std::vector<double> Section::*member) {
    text += fmt::format("static const double {}_{}[{}_SECTIONS][{}_ORDER] = {{\n{}}};\n", function, what, name, name,
                        table(sections, order, member));
  };
  matrix("denominator", &Section::denominator);
  matrix("numerator", &Section::numerator);
  matrix("state", &Section::state);

  std::string driving = fmt::format("  v = {} + ({});", input, number(model.input_bias));
  if (model.input_map) {
    const double half = std::max(0.0, model.input_map->dead_band);
    driving = fmt::format("  v = 0.0;\n  if ({3} > {0}) v = {3} - ({0});\n  if ({3} < {1}) v = {2} * ({3} - ({1}));",
                          number(model.input_map->null + half), number(model.input_map->null - half),
                          number(model.input_map->negative_gain_ratio), input);
  }
  return text +
         filled(kFunctions,
                {{"DRIVING", driving}, {"INPUT_NAME", input}, {"NAME_", name + "_"}, {"FUNCTION_", function + "_"}});
}

}  // namespace eha::ident
