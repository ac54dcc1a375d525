// SPDX-License-Identifier: GPL-3.0-or-later
#include <nlohmann/json.hpp>
#include <vector>

#include "ident/model/model_file.hpp"
#include "ident/model/structure_node.hpp"

namespace eha::ident {
namespace {

/// Keeps keys in the order they are written.
using OrderedJson = nlohmann::ordered_json;

OrderedJson terms_to_json(const std::vector<Term>& terms) {
  OrderedJson list = OrderedJson::array();
  for (const Term& term : terms) list.push_back({{"coefficient", term.coefficient}, {"order", term.order}});
  return list;
}

OrderedJson score_to_json(const Score& score) {
  return {{"r2_percent", score.r2_percent}, {"mse", score.mse}, {"fit_percent", score.fit_percent}};
}

OrderedJson validation_score_to_json(const Score& score) {
  OrderedJson object = score_to_json(score);
  object["error_min"] = score.error_min;
  object["error_max"] = score.error_max;
  object["samples"] = score.samples;
  return object;
}

OrderedJson correlation_to_json(const Correlation& correlation) {
  return {{"lags", correlation.lags},
          {"values", correlation.values},
          {"bound95", correlation.bound95},
          {"bound99", correlation.bound99}};
}

OrderedJson parameters_to_json(const std::vector<ParameterEstimate>& parameters) {
  OrderedJson list = OrderedJson::array();
  for (const ParameterEstimate& parameter : parameters) {
    list.push_back({{"name", parameter.name},
                    {"value", parameter.value},
                    {"std", parameter.std},
                    {"lower95", parameter.lower95},
                    {"upper95", parameter.upper95},
                    {"fixed", parameter.fixed}});
  }
  return list;
}

OrderedJson estimation_to_json(const EstimationReport& report) {
  OrderedJson object = score_to_json(report.score);
  object["samples"] = report.score.samples;
  object["evaluations"] = report.evaluations;
  object["seconds"] = report.seconds;
  object["termination"] = report.termination;
  object["converged"] = report.converged;
  if (report.information) {
    const InformationCriteria& i = *report.information;
    object["information"] = {{"parameters", i.parameters},
                             {"effective_samples", i.effective_samples},
                             {"aic", i.aic},
                             {"aicc", i.aicc},
                             {"bic", i.bic},
                             {"fpe", i.fpe},
                             {"ar_bic", i.ar_bic},
                             {"ar_order", i.ar_order},
                             {"samples", i.samples},
                             {"record", i.record}};
    OrderedJson left_out = OrderedJson::array();
    for (const LeftOut& entry : i.left_out) left_out.push_back({{"order", entry.order}, {"rise", entry.rise}});
    object["information"]["left_out"] = std::move(left_out);
  }
  if (report.correlation) {
    object["correlation"] = {{"names", report.correlation->names},
                             {"matrix", report.correlation->matrix},
                             {"indistinguishable", report.correlation->indistinguishable}};
  }
  if (report.compared_step_s) object["compared_step_s"] = *report.compared_step_s;
  if (report.input_range) object["input_range"] = {report.input_range->first, report.input_range->second};
  if (report.noise) {
    object["noise"] = {{"power", report.noise->power},
                       {"variance", report.noise->variance},
                       {"coefficients", report.noise->coefficients},
                       {"autocorrelation", report.noise->autocorrelation},
                       {"with_parameters", report.noise->with_parameters}};
  }
  return object;
}

OrderedJson test_to_json(const ResidualTest& test) {
  return {{"statistic", test.statistic}, {"degrees", test.degrees}, {"p", test.p}};
}

OrderedJson verdict_to_json(const Verdict& verdict) {
  OrderedJson criteria = OrderedJson::array();
  for (const Criterion& c : verdict.criteria) {
    const OrderedJson passed = c.judged ? OrderedJson(c.passed) : OrderedJson(nullptr);
    criteria.push_back({{"name", name_of(c)}, {"value", c.value}, {"limit", c.limit}, {"passed", passed}});
  }
  OrderedJson object = {{"accepted", verdict.accepted},
                        {"grade", text(verdict.grade)},
                        {"criteria", std::move(criteria)},
                        {"reasons", verdict.reasons}};
  if (verdict.usable_band) {
    object["usable_band_Hz"] = {verdict.usable_band->lowest_Hz, verdict.usable_band->highest_Hz};
  }
  if (verdict.beside_ladder) object["beside_ladder"] = true;
  if (verdict.judging_part_rests) object["judging_part_rests"] = true;
  if (!verdict.word.empty()) object["word"] = verdict.word;
  if (!verdict.explained_by.empty()) object["explained_by"] = verdict.explained_by;
  if (verdict.error_over_recommended) object["error_over_recommended"] = *verdict.error_over_recommended;
  return object;
}

OrderedJson validation_to_json(const ValidationReport& report) {
  OrderedJson object = validation_score_to_json(report.score);
  object["acf"] = correlation_to_json(report.acf);
  object["ccf"] = correlation_to_json(report.ccf);
  for (const NamedStatistic& statistic : kValidationStatistics) object[statistic.name] = report.*statistic.value;
  if (report.tests) {
    object["residual_tests"] = {{"ar_order", report.tests->ar_order},
                                {"input", test_to_json(report.tests->input)},
                                {"whiteness", test_to_json(report.tests->whiteness)}};
    if (const auto& drift = report.tests->drift) {
      object["residual_tests"]["drift"] = {{"change", drift->change}, {"expected", drift->expected}};
    }
    if (const auto& future = report.tests->future_input) {
      object["residual_tests"]["future_input"] = test_to_json(*future);
    }
    if (const auto& nonlinearity = report.tests->nonlinearity) {
      object["residual_tests"]["nonlinearity"] = test_to_json(nonlinearity->test);
      object["residual_tests"]["nonlinearity"]["kind"] = text(nonlinearity->kind);
      if (nonlinearity->or_kind) object["residual_tests"]["nonlinearity"]["or_kind"] = text(*nonlinearity->or_kind);
      if (nonlinearity->gain != GainTrend::unknown)
        object["residual_tests"]["nonlinearity"]["gain"] = text(nonlinearity->gain);
    }
    if (report.tests->moved) object["residual_tests"]["moved_samples"] = *report.tests->moved;
    if (const auto& error = report.tests->error) {
      object["residual_tests"]["error_percent"] = {error->lower, error->upper};
    }
  }
  if (report.extrapolated_percent) object["extrapolated_percent"] = *report.extrapolated_percent;
  if (report.saturated_percent) object["saturated_percent"] = *report.saturated_percent;
  if (const auto& stop = report.end_stop) {
    OrderedJson written = {{"level", stop->level}, {"from_s", stop->from_s}, {"percent", stop->percent}};
    if (stop->other) written["other"] = {{"level", stop->other->level}, {"from_s", stop->other->from_s}};
    if (stop->clean_from_s) written["clean_from_s"] = *stop->clean_from_s;
    if (stop->clean_to_s) written["clean_to_s"] = *stop->clean_to_s;
    if (stop->does_not_answer) written["does_not_answer"] = true;
    if (stop->to_s) written["to_s"] = *stop->to_s;
    object["end_stop"] = std::move(written);
  }
  if (const auto& jump = report.jump) {
    object["jump"] = {{"time_s", jump->time_s}, {"change", jump->change}, {"usual", jump->usual}};
    if (jump->estimating) object["jump"]["estimating"] = true;
    if (jump->until_s) object["jump"]["until_s"] = *jump->until_s;
  }
  if (report.excitation_order) object["excitation_order"] = *report.excitation_order;
  if (report.map_error) object["map_error"] = *report.map_error;
  if (report.between_rows) object["between_rows"] = *report.between_rows;
  if (report.sensor_step) object["sensor_step"] = report.sensor_step->step;
  if (const auto& noise = report.input_noise) {
    object["input_noise"] = {{"rms", noise->rms},
                             {"in_output", noise->in_output},
                             {"share", noise->share},
                             {"attenuation", noise->attenuation}};
    if (noise->step > 0.0) object["input_noise"]["step"] = noise->step;
  }
  if (report.faster_r2_percent) object["faster_r2_percent"] = *report.faster_r2_percent;
  if (const auto& levels = report.input_levels) object["input_levels"] = {levels->lower, levels->upper};
  if (report.offset_reestimated) object["offset_reestimated"] = validation_score_to_json(*report.offset_reestimated);
  return object;
}

}  // namespace

std::string to_text(const Model& model) {
  OrderedJson object;
  object["schema"] = "eha-model/1";
  object["name"] = model.name;
  if (model.input_map) {
    object["input_map"] = {{"kind", "valve"},
                           {"null", model.input_map->null},
                           {"dead_band", model.input_map->dead_band},
                           {"negative_gain_ratio", model.input_map->negative_gain_ratio}};
  }
  if (model.grey_box) {
    OrderedJson box{{"kind", model.grey_box->kind->name}};
    for (std::size_t i = 0; i < model.grey_box->values.size(); ++i) {
      box[std::string(model.grey_box->kind->parameters[i].name)] = model.grey_box->values[i];
    }
    object["grey_box"] = std::move(box);
  }
  object["transfer_function"] = {{"numerator", terms_to_json(model.transfer_function.numerator)},
                                 {"denominator", terms_to_json(model.transfer_function.denominator)},
                                 {"delay_s", model.transfer_function.delay_s}};
  if (model.structure) object["structure"] = structure_to_json(*model.structure);
  object["input_bias"] = model.input_bias;
  object["initial_output"] = model.initial_output;
  if (!model.initial_state.empty()) object["initial_state"] = model.initial_state;
  for (const PastInput& window : model.past_input) {
    object["past_input"].push_back({{"from_s", window.from_s}, {"to_s", window.to_s}, {"value", window.value}});
  }
  object["units"] = {{"input", model.input_unit}, {"output", model.output_unit}, {"time", "s"}};
  object["parameters"] = parameters_to_json(model.parameters);
  if (model.estimation) object["estimation"] = estimation_to_json(*model.estimation);
  if (model.validation) object["validation"] = validation_to_json(*model.validation);
  if (model.stability) {
    object["stability"] = {{"stable", model.stability->stable},
                           {"test", model.stability->test},
                           {"margin_rad", model.stability->margin_rad}};
    if (model.stability->integrator_order > 0.0) {
      object["stability"]["integrator_order"] = model.stability->integrator_order;
    }
  }
  if (model.bode) {
    object["bode"] = {{"frequency_Hz", model.bode->frequency_Hz},
                      {"gain_dB", model.bode->gain_dB},
                      {"gain_std_dB", model.bode->gain_std_dB},
                      {"phase_deg", model.bode->phase_deg},
                      {"phase_std_deg", model.bode->phase_std_deg}};
  }
  if (model.verdict) object["verdict"] = verdict_to_json(*model.verdict);
  object["procedure"] = model.procedure;
  object["provenance"] = OrderedJson::object();
  for (const auto& [key, value] : model.provenance) object["provenance"][key] = value;
  return object.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

}  // namespace eha::ident
