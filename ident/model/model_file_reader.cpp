// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "ident/model/model_file.hpp"

namespace eha::ident {
namespace {

/// Sorted keys: finds each in logarithmic time, also in a hostile file.
using Json = nlohmann::json;

constexpr std::string_view kSchema = "eha-model/1";
/// A model file is seven levels deep; a far deeper one is refused.
constexpr int kDeepest = 32;

/// One JSON value and its path, for messages.
class Node {
 public:
  Node(const Json& value, std::string path, const std::string& file_name)
      : value_(&value), path_(std::move(path)), file_name_(&file_name) {}

  [[noreturn]] void refuse(std::string_view expected, std::string_view got) const {
    throw ConfigError(
        fmt::format("{}: {}: expected {}, got {}", *file_name_, path_.empty() ? "model" : path_, expected, got));
  }
  [[noreturn]] void refuse(std::string_view expected) const { refuse(expected, excerpt()); }

  [[nodiscard]] bool has(const char* key) const { return value_->contains(key); }
  [[nodiscard]] bool is_null() const { return value_->is_null(); }

  [[nodiscard]] Node at(const char* key) const {
    if (!has(key)) child(key, Json()).refuse("a value", "no such field");
    return child(key, (*value_)[key]);
  }

  [[nodiscard]] Node object(const std::vector<std::string_view>& keys) const {
    if (!value_->is_object()) refuse("an object");
    for (const auto& [key, value] : value_->items()) {
      if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
      child(key, value).refuse("a known field" + suggestion(key, keys), "an unknown one");
    }
    return *this;
  }

  [[nodiscard]] std::vector<Node> list() const {
    if (!value_->is_array()) refuse("an array");
    std::vector<Node> nodes;
    nodes.reserve(value_->size());
    for (std::size_t i = 0; i < value_->size(); ++i) {
      nodes.emplace_back((*value_)[i], fmt::format("{}[{}]", path_, i), *file_name_);
    }
    return nodes;
  }

  [[nodiscard]] double number() const {
    if (!value_->is_number()) refuse("a number");
    return value_->get<double>();
  }

  void read(double& target) const { target = value_->is_null() ? std::numeric_limits<double>::quiet_NaN() : number(); }
  void read(std::string& target) const {
    if (!value_->is_string()) refuse("a string");
    target = value_->get<std::string>();
  }
  void read(bool& target) const {
    if (!value_->is_boolean()) refuse("true or false");
    target = value_->get<bool>();
  }
  void read(std::size_t& target) const {
    if (!value_->is_number_unsigned()) refuse("a whole number of at least 0");
    target = value_->get<std::size_t>();
  }
  void read(int& target) const {
    const bool fits = value_->is_number_integer() && value_->get<double>() >= std::numeric_limits<int>::min() &&
                      value_->get<double>() <= std::numeric_limits<int>::max();
    if (!fits) refuse("a whole number");
    target = value_->get<int>();
  }
  template <typename T>
  void read(std::vector<T>& target) const {
    for (const Node& node : list()) node.read(target.emplace_back());
  }
  template <typename T>
  void read(const char* key, T& target) const {
    if (has(key)) child(key, (*value_)[key]).read(target);
  }

  /// A string as it is, anything else as JSON text.
  [[nodiscard]] std::map<std::string, std::string> texts() const {
    if (!value_->is_object()) refuse("an object");
    std::map<std::string, std::string> result;
    for (const auto& [key, value] : value_->items()) {
      result[key] = value.is_string() ? value.get<std::string>() : value.dump();
    }
    return result;
  }

 private:
  [[nodiscard]] Node child(const std::string& key, const Json& value) const {
    const std::string name = shortened(key, 60);
    return {value, path_.empty() ? name : path_ + "." + name, *file_name_};
  }
  [[nodiscard]] std::string excerpt() const {
    if (value_->is_structured()) return value_->is_array() ? "an array" : "an object";
    return shortened(value_->dump(-1, ' ', true, Json::error_handler_t::replace), 40);
  }

  const Json* value_;
  std::string path_;
  const std::string* file_name_;
};

std::vector<Term> read_terms(const Node& node) {
  std::vector<Term> terms;
  for (const Node& entry : node.list()) {
    const Node term = entry.object({"coefficient", "order"});
    terms.push_back({term.at("coefficient").number(), term.at("order").number()});
  }
  return terms;
}

TransferFunction read_transfer_function(const Node& node) {
  const Node object = node.object({"numerator", "denominator", "delay_s"});
  TransferFunction g;
  g.numerator = read_terms(object.at("numerator"));
  g.denominator = read_terms(object.at("denominator"));
  if (object.has("delay_s")) g.delay_s = object.at("delay_s").number();
  return g;
}

ValveMap read_input_map(const Node& node) {
  const Node object = node.object({"kind", "null", "dead_band", "negative_gain_ratio"});
  std::string kind;
  object.at("kind").read(kind);
  if (kind != "valve") object.at("kind").refuse("\"valve\"");
  const ValveMap map{object.at("null").number(), object.at("dead_band").number(),
                     object.at("negative_gain_ratio").number()};
  if (!(map.dead_band >= 0.0)) object.at("dead_band").refuse("at least 0");
  return map;
}

/// @param numerator_terms  of the model
ParameterEstimate read_parameter(const Node& node, std::size_t numerator_terms) {
  const Node object = node.object({"name", "value", "std", "lower95", "upper95", "fixed"});
  ParameterEstimate parameter;
  object.at("name").read(parameter.name);
  parameter.role = key_of(parameter.name, numerator_terms).role;
  object.at("value").read(parameter.value);
  object.read("std", parameter.std);
  object.read("lower95", parameter.lower95);
  object.read("upper95", parameter.upper95);
  object.read("fixed", parameter.fixed);
  return parameter;
}

Score read_score(const Node& node) {
  Score score;
  node.read("r2_percent", score.r2_percent);
  node.read("mse", score.mse);
  node.read("fit_percent", score.fit_percent);
  node.read("error_min", score.error_min);
  node.read("error_max", score.error_max);
  node.read("samples", score.samples);
  return score;
}

Correlation read_correlation(const Node& node) {
  const Node object = node.object({"lags", "values", "bound95", "bound99"});
  Correlation correlation;
  object.read("lags", correlation.lags);
  object.read("values", correlation.values);
  object.read("bound95", correlation.bound95);
  object.read("bound99", correlation.bound99);
  if (correlation.lags.size() != correlation.values.size()) {
    object.refuse("as many values as lags",
                  fmt::format("{} and {}", correlation.values.size(), correlation.lags.size()));
  }
  return correlation;
}

InformationCriteria read_information(const Node& node) {
  const Node object = node.object({"parameters", "effective_samples", "aic", "aicc", "bic", "fpe", "ar_bic", "ar_order",
                                   "samples", "record", "left_out"});
  InformationCriteria criteria;
  object.read("parameters", criteria.parameters);
  object.read("effective_samples", criteria.effective_samples);
  object.read("aic", criteria.aic);
  object.read("aicc", criteria.aicc);
  object.read("bic", criteria.bic);
  object.read("fpe", criteria.fpe);
  object.read("ar_bic", criteria.ar_bic);
  object.read("ar_order", criteria.ar_order);
  object.read("samples", criteria.samples);
  object.read("record", criteria.record);
  if (!object.has("left_out")) return criteria;
  for (const Node& entry : object.at("left_out").list()) {
    const Node left_out = entry.object({"order", "rise"});
    LeftOut& target = criteria.left_out.emplace_back();
    left_out.at("order").read(target.order);
    left_out.at("rise").read(target.rise);
    // A term without which there is no model costs without limit, which JSON writes as null.
    if (std::isnan(target.rise)) target.rise = std::numeric_limits<double>::infinity();
  }
  return criteria;
}

ParameterCorrelation read_parameter_correlation(const Node& node) {
  const Node object = node.object({"names", "matrix", "indistinguishable"});
  ParameterCorrelation correlation;
  object.read("names", correlation.names);
  if (object.has("matrix")) {
    for (const Node& row : object.at("matrix").list()) row.read(correlation.matrix.emplace_back());
  }
  object.read("indistinguishable", correlation.indistinguishable);
  return correlation;
}

EstimationReport read_estimation(const Node& node) {
  const Node object = node.object({"r2_percent", "mse", "fit_percent", "samples", "evaluations", "seconds",
                                   "termination", "converged", "information", "correlation"});
  EstimationReport report;
  report.score = read_score(object);
  object.read("evaluations", report.evaluations);
  object.read("seconds", report.seconds);
  object.read("termination", report.termination);
  object.read("converged", report.converged);
  if (object.has("information")) report.information = read_information(object.at("information"));
  if (object.has("correlation")) report.correlation = read_parameter_correlation(object.at("correlation"));
  return report;
}

ResidualTest read_test(const Node& node) {
  const Node object = node.object({"statistic", "degrees", "p"});
  ResidualTest test;
  object.read("statistic", test.statistic);
  object.read("degrees", test.degrees);
  object.read("p", test.p);
  return test;
}

ValidationReport read_validation(const Node& node) {
  std::vector<std::string_view> keys{"r2_percent",
                                     "mse",
                                     "fit_percent",
                                     "error_min",
                                     "error_max",
                                     "samples",
                                     "acf",
                                     "ccf",
                                     "residual_tests",
                                     "extrapolated_percent",
                                     "saturated_percent",
                                     "excitation_order",
                                     "offset_reestimated"};
  for (const NamedStatistic& statistic : kValidationStatistics) keys.push_back(statistic.name);
  const Node object = node.object(keys);
  ValidationReport report;
  report.score = read_score(object);
  if (object.has("acf")) report.acf = read_correlation(object.at("acf"));
  if (object.has("ccf")) report.ccf = read_correlation(object.at("ccf"));
  for (const NamedStatistic& statistic : kValidationStatistics) object.read(statistic.name, report.*statistic.value);
  if (object.has("residual_tests")) {
    const Node tests = object.at("residual_tests").object({"ar_order", "input", "whiteness", "drift"});
    report.tests.emplace();
    tests.read("ar_order", report.tests->ar_order);
    if (tests.has("input")) report.tests->input = read_test(tests.at("input"));
    if (tests.has("whiteness")) report.tests->whiteness = read_test(tests.at("whiteness"));
    if (tests.has("drift")) {
      const Node drift = tests.at("drift").object({"change", "expected"});
      drift.read("change", report.tests->drift.emplace().change);
      drift.read("expected", report.tests->drift->expected);
    }
  }
  if (object.has("extrapolated_percent")) object.read("extrapolated_percent", report.extrapolated_percent.emplace());
  if (object.has("saturated_percent")) object.read("saturated_percent", report.saturated_percent.emplace());
  if (object.has("excitation_order")) object.read("excitation_order", report.excitation_order.emplace());
  if (object.has("offset_reestimated")) {
    report.offset_reestimated =
        read_score(object.at("offset_reestimated")
                       .object({"r2_percent", "mse", "fit_percent", "error_min", "error_max", "samples"}));
  }
  return report;
}

StabilityReport read_stability(const Node& node) {
  const Node object = node.object({"stable", "test", "margin_rad", "integrator_order"});
  StabilityReport report;
  object.at("stable").read(report.stable);
  object.read("test", report.test);
  object.read("margin_rad", report.margin_rad);
  if (object.has("integrator_order")) object.read("integrator_order", report.integrator_order);
  return report;
}

BodeCurve read_bode(const Node& node) {
  const Node object = node.object({"frequency_Hz", "gain_dB", "gain_std_dB", "phase_deg", "phase_std_deg"});
  BodeCurve curve;
  object.read("frequency_Hz", curve.frequency_Hz);
  object.read("gain_dB", curve.gain_dB);
  object.read("gain_std_dB", curve.gain_std_dB);
  object.read("phase_deg", curve.phase_deg);
  object.read("phase_std_deg", curve.phase_std_deg);
  return curve;
}

Grade read_grade(const Node& node) {
  std::string name;
  node.read(name);
  for (const Grade grade : {Grade::good, Grade::usable, Grade::rejected}) {
    if (name == text(grade)) return grade;
  }
  node.refuse("good, usable or rejected");
}

Verdict read_verdict(const Node& node) {
  const Node object = node.object({"accepted", "grade", "criteria", "reasons", "usable_band_Hz"});
  Verdict verdict;
  object.at("accepted").read(verdict.accepted);
  object.read("reasons", verdict.reasons);
  // Files of earlier versions have no grade.
  verdict.grade = verdict.accepted ? Grade::usable : Grade::rejected;
  if (object.has("grade")) verdict.grade = read_grade(object.at("grade"));
  if (object.has("usable_band_Hz")) {
    std::vector<double> ends;
    object.read("usable_band_Hz", ends);
    if (ends.size() != 2 || !(ends[0] > 0.0) || !(ends[1] >= ends[0])) {
      object.at("usable_band_Hz").refuse("two rising frequencies above 0");
    }
    verdict.usable_band = {ends[0], ends[1]};
  }
  if (!object.has("criteria")) return verdict;
  for (const Node& entry : object.at("criteria").list()) {
    const Node criterion = entry.object({"name", "value", "limit", "passed"});
    Criterion& target = verdict.criteria.emplace_back();
    criterion.at("name").read(target.name);
    criterion.read("value", target.value);
    criterion.read("limit", target.limit);
    target.judged = !criterion.at("passed").is_null();
    if (target.judged) criterion.at("passed").read(target.passed);
  }
  return verdict;
}

/// @param begin_s  where the window after it begins
PastInput read_past_input(const Node& node, double begin_s) {
  const Node object = node.object({"from_s", "to_s", "value"});
  const PastInput window{object.at("from_s").number(), object.at("to_s").number(), object.at("value").number()};
  if (window.to_s != begin_s) object.at("to_s").refuse(fmt::format("{}, where the window after it begins", begin_s));
  if (!(window.from_s < window.to_s)) object.at("from_s").refuse("less than to_s");
  return window;
}

Model read_model(const Node& node, const std::string& file_name) {
  const Node object = node.object({"schema", "name", "input_map", "transfer_function", "input_bias", "initial_output",
                                   "initial_state", "past_input", "units", "parameters", "estimation", "validation",
                                   "stability", "bode", "verdict", "procedure", "provenance"});
  std::string schema(kSchema);
  object.read("schema", schema);
  if (schema != kSchema) object.at("schema").refuse(fmt::format("\"{}\"", kSchema));

  Model model;
  model.name = std::filesystem::path(file_name).stem().string();
  object.read("name", model.name);
  model.transfer_function = read_transfer_function(object.at("transfer_function"));
  if (object.has("input_map")) model.input_map = read_input_map(object.at("input_map"));
  if (object.has("input_bias")) model.input_bias = object.at("input_bias").number();
  if (model.input_map && model.input_bias != 0.0) object.at("input_bias").refuse("0 beside input_map");
  if (object.has("initial_output")) model.initial_output = object.at("initial_output").number();
  if (object.has("initial_state")) {
    for (const Node& entry : object.at("initial_state").list()) model.initial_state.push_back(entry.number());
  }
  if (object.has("past_input")) {
    double begin_s = 0.0;
    for (const Node& entry : object.at("past_input").list()) {
      model.past_input.push_back(read_past_input(entry, begin_s));
      begin_s = model.past_input.back().from_s;
    }
  }
  if (object.has("units")) {
    const Node units = object.at("units").object({"input", "output", "time"});
    units.read("input", model.input_unit);
    units.read("output", model.output_unit);
    std::string time = "s";
    units.read("time", time);
    if (time != "s") units.at("time").refuse("\"s\"");
  }
  if (object.has("parameters")) {
    for (const Node& entry : object.at("parameters").list())
      model.parameters.push_back(read_parameter(entry, model.transfer_function.numerator.size()));
  }
  if (object.has("estimation")) model.estimation = read_estimation(object.at("estimation"));
  if (object.has("validation")) model.validation = read_validation(object.at("validation"));
  if (object.has("stability")) model.stability = read_stability(object.at("stability"));
  if (object.has("bode")) model.bode = read_bode(object.at("bode"));
  if (object.has("verdict")) model.verdict = read_verdict(object.at("verdict"));
  object.read("procedure", model.procedure);
  if (object.has("provenance")) model.provenance = object.at("provenance").texts();
  return model;
}

/// The JSON library's message without the offending bytes.
std::string syntax_detail(std::string_view what) {
  constexpr std::string_view kMarker = "syntax error ";
  if (const auto start = what.find(kMarker); start != std::string_view::npos)
    what.remove_prefix(start + kMarker.size());
  std::string detail(what.substr(0, what.find("; last read")));
  if (const auto wanted = what.rfind("; expected"); wanted != std::string_view::npos && wanted >= detail.size()) {
    detail += what.substr(wanted);
  }
  return shortened(detail, 160);
}

/// "line:column" of a byte counted from 1.
std::string place(std::string_view text, std::size_t byte) {
  const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t last_break = before.rfind('\n');
  const std::string_view row = last_break == std::string_view::npos ? before : before.substr(last_break + 1);
  // Bytes 10xxxxxx continue a character.
  const auto column = 1 + std::count_if(row.begin(), row.end(), [](char c) { return (c & '\xC0') != '\x80'; });
  return fmt::format("{}:{}", line, column);
}

Json parse(std::string_view text, const std::string& file_name) {
  if (text.find_first_not_of(" \t\r\n") == std::string_view::npos) {
    throw ConfigError(file_name + ": expected a model in JSON, got an empty file");
  }
  if (text.find('\0') != std::string_view::npos) {
    throw ConfigError(file_name + ": expected a model in JSON, got a binary file");
  }
  const auto refuse_depth = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > kDeepest) {
      throw ConfigError(fmt::format("{}: expected a model at most {} levels deep, got more", file_name, kDeepest));
    }
    return true;
  };
  try {
    return Json::parse(text.begin(), text.end(), refuse_depth);
  } catch (const Json::parse_error& error) {
    throw ConfigError(fmt::format("{}:{}: expected a model in JSON, got a syntax error {}", file_name,
                                  place(text, error.byte), syntax_detail(error.what())));
  } catch (const Json::exception& error) {
    throw ConfigError(fmt::format("{}: expected a model in JSON, got {}", file_name, shortened(error.what(), 160)));
  }
}

}  // namespace

Model model_from_text(std::string_view text, const std::string& file_name) {
  const Json json = parse(text, file_name);
  Model model = read_model(Node(json, "", file_name), file_name);
  try {
    check(model.transfer_function);
  } catch (const ConfigError& error) {
    throw ConfigError(file_name + ": " + error.what());
  }
  return model;
}

}  // namespace eha::ident
