// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "ident/export/model_formats.hpp"

namespace eha::ident {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> row(const Eigen::MatrixXd& m, Eigen::Index i) {
  const Eigen::VectorXd values = m.row(i);
  return {values.begin(), values.end()};
}

std::string matrix(const Eigen::MatrixXd& m) {
  if (m.size() == 0) return fmt::format("zeros({}, {})", m.rows(), m.cols());
  std::string text = "[";
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    text += fmt::format("{}{}", i > 0 ? ";\n  " : "", fmt::join(row(m, i), " "));
  return text + "]";
}

Json rows(const Eigen::MatrixXd& m) {
  Json all = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) all.push_back(row(m, i));
  return all;
}

Json terms(const std::vector<Term>& list) {
  Json all = Json::array();
  for (const Term& term : list) all.push_back({{"coefficient", term.coefficient}, {"order", term.order}});
  return all;
}

}  // namespace

std::string state_space_text(const ExportedModel& model, const std::string& function) {
  const StateSpace s = state_space(model.sections);
  std::string text = fmt::format(
      "% {}: x' = A x + B v(t - delay_s), y = initial_output + C x + D v(t - delay_s), x(0) = x0\n", function);
  for (const std::string& line : notes(model)) text += "% " + line + "\n";
  text += fmt::format("A = {};\nB = {};\nC = {};\nD = {};\nx0 = {};\n", matrix(s.a), matrix(s.b),
                      matrix(s.c.transpose()), s.d, matrix(s.x0));
  text += fmt::format("delay_s = {};\ninitial_output = {};\n", model.sections.delay_s, model.initial_output);
  if (model.input_map) {
    text += fmt::format("null = {};\ndead_band = {};\nnegative_gain_ratio = {};\n", model.input_map->null,
                        model.input_map->dead_band, model.input_map->negative_gain_ratio);
  } else {
    text += fmt::format("input_bias = {};\n", model.input_bias);
  }
  return text;
}

std::string json_text(const ExportedModel& model, const std::string& function) {
  const StateSpace s = state_space(model.sections);
  Json document{{"schema", "eha-export/1"}, {"name", function}, {"notes", notes(model)}};
  document["units"] = {{"input", model.input_unit}, {"output", model.output_unit}, {"time", "s"}};
  document["transfer_function"] = {{"numerator", terms(model.transfer_function.numerator)},
                                   {"denominator", terms(model.transfer_function.denominator)},
                                   {"delay_s", model.transfer_function.delay_s}};
  if (model.input_map) {
    document["input_map"] = {{"kind", "valve"},
                             {"null", model.input_map->null},
                             {"dead_band", model.input_map->dead_band},
                             {"negative_gain_ratio", model.input_map->negative_gain_ratio}};
  }
  document["input_bias"] = model.input_bias;
  document["initial_output"] = model.initial_output;
  document["state_space"] = {{"A", rows(s.a)},
                             {"B", std::vector<double>(s.b.begin(), s.b.end())},
                             {"C", std::vector<double>(s.c.begin(), s.c.end())},
                             {"D", s.d},
                             {"x0", std::vector<double>(s.x0.begin(), s.x0.end())},
                             {"delay_s", model.sections.delay_s},
                             {"exact", !model.error}};
  if (model.error) {
    document["approximation"] = {{"band_Hz", {model.error->band.lowest_Hz, model.error->band.highest_Hz}},
                                 {"gain_percent", model.error->gain_percent},
                                 {"phase_deg", model.error->phase_deg},
                                 {"step_percent", model.error->step_percent},
                                 {"multisine_percent", model.error->multisine_percent}};
  }
  document["fomcon"] = fomcon_line(model.transfer_function);
  document["crone"] = crone_line(model.transfer_function);
  return document.dump(2, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace eha::ident
