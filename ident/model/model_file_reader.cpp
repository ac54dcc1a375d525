// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/unit_names.hpp"
#include "ident/model/earlier_files.hpp"
#include "ident/model/grey_box_output.hpp"
#include "ident/model/model_file.hpp"
#include "ident/model/model_node.hpp"
#include "ident/model/structure_node.hpp"

namespace eha::ident {
namespace {

using Node = ModelNode;

constexpr std::string_view kSchema = "eha-model/1";

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

GreyBox read_grey_box(const Node& node) {
  std::string name;
  node.at("kind").read(name);
  std::string names;
  for (const GreyBoxKind* kind : grey_box_kinds()) {
    names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", kind->name);
    if (kind->name != name) continue;
    std::vector<std::string> texts;
    for (const GreyBoxParameter& parameter : kind->parameters) texts.emplace_back(parameter.name);
    std::vector<std::string_view> keys{"kind"};
    keys.insert(keys.end(), texts.begin(), texts.end());
    const Node object = node.object(keys);
    GreyBox box{kind, {}};
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const Node value = object.at(texts[i].c_str());
      box.values.push_back(value.number());
      if (kind->parameters[i].positive && !(box.values[i] > 0.0)) value.refuse("more than 0");
    }
    return box;
  }
  node.at("kind").refuse("one of " + names);
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
    // If a model is impossible without the term, the rise is infinite, which JSON writes as null.
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

ResidualNoise read_noise(const Node& node) {
  const Node object = node.object({"power", "variance", "coefficients", "autocorrelation", "with_parameters"});
  ResidualNoise noise;
  noise.power = object.at("power").number();
  noise.variance = object.at("variance").number();
  object.read("coefficients", noise.coefficients);
  object.read("autocorrelation", noise.autocorrelation);
  object.read("with_parameters", noise.with_parameters);
  if (!(noise.power > 0.0)) object.at("power").refuse("more than 0");
  if (!(noise.variance > 0.0)) object.at("variance").refuse("more than 0");
  if (noise.autocorrelation.size() != noise.coefficients.size() + 1) {
    object.refuse("one autocorrelation more than coefficients",
                  fmt::format("{} and {}", noise.autocorrelation.size(), noise.coefficients.size()));
  }
  return noise;
}

EstimationReport read_estimation(const Node& node) {
  const Node object =
      node.object({"r2_percent", "mse", "fit_percent", "samples", "evaluations", "seconds", "termination", "converged",
                   "information", "correlation", "compared_step_s", "input_range", "noise"});
  EstimationReport report;
  report.score = read_score(object);
  object.read("evaluations", report.evaluations);
  object.read("seconds", report.seconds);
  object.read("termination", report.termination);
  object.read("converged", report.converged);
  if (object.has("information")) report.information = read_information(object.at("information"));
  if (object.has("correlation")) report.correlation = read_parameter_correlation(object.at("correlation"));
  if (object.has("compared_step_s")) {
    report.compared_step_s = object.at("compared_step_s").number();
    if (!(*report.compared_step_s > 0.0)) object.at("compared_step_s").refuse("more than 0");
  }
  if (object.has("input_range")) {
    std::vector<double> ends;
    object.read("input_range", ends);
    if (ends.size() != 2 || !(ends[1] >= ends[0])) object.at("input_range").refuse("two rising values");
    report.input_range = {ends[0], ends[1]};
  }
  if (object.has("noise")) report.noise = read_noise(object.at("noise"));
  return report;
}

void read_into(const Node& object, ResidualTest& test) {
  object.read("statistic", test.statistic);
  object.read("degrees", test.degrees);
  object.read("p", test.p);
}

ResidualTest read_test(const Node& node) {
  ResidualTest test;
  read_into(node.object({"statistic", "degrees", "p"}), test);
  return test;
}

NonlinearityTest read_nonlinearity(const Node& node) {
  const Node object = node.object({"statistic", "degrees", "p", "kind", "gain", "or_kind"});
  NonlinearityTest nonlinearity;
  read_into(object, nonlinearity.test);
  std::string kind;
  object.read("kind", kind);
  std::string other;
  if (object.has("or_kind")) object.read("or_kind", other);
  for (const NonlinearKind known : {NonlinearKind::level, NonlinearKind::direction, NonlinearKind::motion,
                                    NonlinearKind::position, NonlinearKind::time}) {
    if (kind == text(known)) nonlinearity.kind = known;
    if (other == text(known)) nonlinearity.or_kind = known;
  }
  std::string gain;
  if (object.has("gain")) object.read("gain", gain);
  for (const GainTrend known : {GainTrend::falls, GainTrend::grows}) {
    if (gain == text(known)) nonlinearity.gain = known;
  }
  return nonlinearity;
}

ValidationReport read_validation(const Node& node) {
  std::vector<std::string_view> keys{
      "r2_percent",        "mse",         "fit_percent", "error_min",        "error_max",
      "samples",           "acf",         "ccf",         "residual_tests",   "extrapolated_percent",
      "saturated_percent", "end_stop",    "jump",        "excitation_order", "input_levels",
      "map_error",         "input_noise", "sensor_step", "between_rows",     "faster_r2_percent",
      "offset_reestimated"};
  for (const NamedStatistic& statistic : kValidationStatistics) keys.push_back(statistic.name);
  const Node object = node.object(keys);
  ValidationReport report;
  report.score = read_score(object);
  if (object.has("acf")) report.acf = read_correlation(object.at("acf"));
  if (object.has("ccf")) report.ccf = read_correlation(object.at("ccf"));
  for (const NamedStatistic& statistic : kValidationStatistics) object.read(statistic.name, report.*statistic.value);
  if (object.has("residual_tests")) {
    const Node tests = object.at("residual_tests")
                           .object({"ar_order", "input", "whiteness", "drift", "future_input", "nonlinearity",
                                    "error_percent", "moved_samples"});
    report.tests.emplace();
    tests.read("ar_order", report.tests->ar_order);
    if (tests.has("input")) report.tests->input = read_test(tests.at("input"));
    if (tests.has("whiteness")) report.tests->whiteness = read_test(tests.at("whiteness"));
    if (tests.has("drift")) {
      const Node drift = tests.at("drift").object({"change", "expected"});
      drift.read("change", report.tests->drift.emplace().change);
      drift.read("expected", report.tests->drift->expected);
    }
    if (tests.has("future_input")) report.tests->future_input = read_test(tests.at("future_input"));
    if (tests.has("nonlinearity")) report.tests->nonlinearity = read_nonlinearity(tests.at("nonlinearity"));
    if (tests.has("moved_samples")) tests.read("moved_samples", report.tests->moved.emplace());
    if (tests.has("error_percent")) {
      std::vector<double> error;
      tests.read("error_percent", error);
      if (error.size() == 2) report.tests->error = PredictedError{error[0], error[1]};
    }
  }
  if (object.has("extrapolated_percent")) object.read("extrapolated_percent", report.extrapolated_percent.emplace());
  if (object.has("saturated_percent")) object.read("saturated_percent", report.saturated_percent.emplace());
  if (object.has("end_stop")) {
    const Node stop =
        object.at("end_stop")
            .object({"level", "from_s", "percent", "other", "clean_from_s", "clean_to_s", "does_not_answer", "to_s"});
    EndStop& read = report.end_stop.emplace();
    stop.read("level", read.level);
    stop.read("from_s", read.from_s);
    stop.read("percent", read.percent);
    if (stop.has("other")) {
      const Node other = stop.at("other").object({"level", "from_s"});
      other.read("level", read.other.emplace().level);
      other.read("from_s", read.other->from_s);
    }
    if (stop.has("clean_from_s")) stop.read("clean_from_s", read.clean_from_s.emplace());
    if (stop.has("clean_to_s")) stop.read("clean_to_s", read.clean_to_s.emplace());
    if (stop.has("does_not_answer")) stop.read("does_not_answer", read.does_not_answer);
    if (stop.has("to_s")) stop.read("to_s", read.to_s.emplace());
  }
  if (object.has("jump")) {
    const Node jump = object.at("jump").object({"time_s", "change", "usual", "estimating", "until_s"});
    jump.read("time_s", report.jump.emplace().time_s);
    jump.read("change", report.jump->change);
    if (jump.has("usual")) jump.read("usual", report.jump->usual);
    jump.read("estimating", report.jump->estimating);
    if (jump.has("until_s")) jump.read("until_s", report.jump->until_s.emplace());
  }
  if (object.has("excitation_order")) object.read("excitation_order", report.excitation_order.emplace());
  if (object.has("map_error")) object.read("map_error", report.map_error.emplace());
  if (object.has("between_rows")) object.read("between_rows", report.between_rows.emplace());
  if (object.has("sensor_step")) object.read("sensor_step", report.sensor_step.emplace().step);
  if (object.has("input_noise")) {
    const Node noise = object.at("input_noise").object({"rms", "in_output", "share", "attenuation", "step"});
    noise.read("rms", report.input_noise.emplace().rms);
    noise.read("in_output", report.input_noise->in_output);
    noise.read("share", report.input_noise->share);
    noise.read("attenuation", report.input_noise->attenuation);
    if (noise.has("step")) noise.read("step", report.input_noise->step);
  }
  if (object.has("faster_r2_percent")) object.read("faster_r2_percent", report.faster_r2_percent.emplace());
  if (object.has("input_levels")) {
    std::vector<double> levels;
    object.read("input_levels", levels);
    if (levels.size() == 2) report.input_levels = InputLevels{levels[0], levels[1]};
  }
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
  const Node object = node.object({"accepted", "grade", "criteria", "reasons", "usable_band_Hz", "beside_ladder",
                                   "judging_part_rests", "word", "explained_by", "error_over_recommended"});
  Verdict verdict;
  object.at("accepted").read(verdict.accepted);
  object.read("reasons", verdict.reasons);
  object.read("beside_ladder", verdict.beside_ladder);
  object.read("judging_part_rests", verdict.judging_part_rests);
  object.read("word", verdict.word);
  object.read("explained_by", verdict.explained_by);
  if (object.has("error_over_recommended")) {
    object.at("error_over_recommended").read(verdict.error_over_recommended.emplace());
  }
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
    std::string name;
    criterion.at("name").read(name);
    Criterion& target = verdict.criteria.emplace_back(criterion_named(name));
    criterion.read("value", target.value);
    criterion.read("limit", target.limit);
    target.judged = !criterion.at("passed").is_null();
    if (target.judged) criterion.at("passed").read(target.passed);
  }
  return verdict;
}

/// @param begin_s  start of the next window
PastInput read_past_input(const Node& node, double begin_s) {
  const Node object = node.object({"from_s", "to_s", "value"});
  const PastInput window{object.at("from_s").number(), object.at("to_s").number(), object.at("value").number()};
  if (window.to_s != begin_s) object.at("to_s").refuse(fmt::format("{}, where the window after it begins", begin_s));
  if (!(window.from_s < window.to_s)) object.at("from_s").refuse("less than to_s");
  return window;
}

Model read_model(const Node& node, const std::string& file_name) {
  const Node object =
      node.object({"schema", "name", "input_map", "grey_box", "transfer_function", "structure", "input_bias",
                   "initial_output", "initial_state", "past_input", "units", "parameters", "estimation", "validation",
                   "stability", "bode", "verdict", "procedure", "provenance"});
  std::string schema(kSchema);
  object.read("schema", schema);
  if (schema != kSchema) object.at("schema").refuse(fmt::format("\"{}\"", kSchema));

  Model model;
  model.name = std::filesystem::path(file_name).stem().string();
  object.read("name", model.name);
  model.transfer_function = read_transfer_function(object.at("transfer_function"));
  if (object.has("structure")) {
    model.structure = read_structure(object.at("structure"));
    model.structure->name = model.name;
  }
  if (object.has("input_map")) model.input_map = read_input_map(object.at("input_map"));
  if (object.has("grey_box")) {
    model.grey_box = read_grey_box(object.at("grey_box"));
    if (model.input_map) object.at("input_map").refuse("none beside grey_box");
    model.transfer_function = linear_form(*model.grey_box, model.transfer_function.delay_s);
  }
  if (object.has("input_bias")) model.input_bias = object.at("input_bias").number();
  if (model.input_map && model.input_bias != 0.0) object.at("input_bias").refuse("0 beside input_map");
  if (object.has("initial_output")) model.initial_output = object.at("initial_output").number();
  if (object.has("initial_state")) {
    for (const Node& entry : object.at("initial_state").list()) model.initial_state.push_back(entry.number());
  }
  if (model.grey_box && model.initial_state.size() > model.grey_box->kind->states) {
    object.at("initial_state").refuse(fmt::format("at most {} states", model.grey_box->kind->states));
  }
  if (object.has("past_input")) {
    if (model.grey_box) object.at("past_input").refuse("none beside grey_box");
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
    model.input_unit = unit_as_written_here(model.input_unit);
    model.output_unit = unit_as_written_here(model.output_unit);
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

}  // namespace

Model model_from_text(std::string_view text, const std::string& file_name) {
  const ModelNode::Json json = parse_model_json(text, file_name);
  Model model = read_model(ModelNode(json, "", file_name), file_name);
  try {
    check(model.transfer_function);
  } catch (const ConfigError& error) {
    throw ConfigError(file_name + ": " + error.what());
  }
  complete_earlier(model);
  return model;
}

}  // namespace eha::ident
