// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "core/error.hpp"
#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/grey_box_fit.hpp"
#include "ident/estimation/inside_fits.hpp"
#include "ident/estimation/left_out.hpp"
#include "ident/estimation/paper_procedure.hpp"
#include "ident/estimation/sub_structures.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/model/record_start.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

void check_input(const Record& record, const StructureOptions& asked, const FitOptions& options) {
  if (options.input_before && !std::isfinite(*options.input_before)) {
    throw ConfigError(fmt::format("input_before: expected a finite input, got {}", *options.input_before));
  }
  if (options.input_before && find_request(asked, asked.structure.input_map.bias) != nullptr) {
    throw ConfigError(fmt::format(
        "model {}: input_before makes the bias {}, so that the plant begins at rest; leave out one of input_before and "
        "the request for {}",
        asked.name, -*options.input_before, asked.structure.input_map.bias.key.name));
  }
  if (!is_constant(record.input)) {
    require_more_than_two_levels(asked, record.input, record.input_channel.unit);
    return;
  }
  const std::string& unit = record.input_channel.unit;
  const std::string input = fmt::format("record: the input is constant at {} {}", record.input[0], unit);
  if (options.input_before && *options.input_before == record.input[0]) {
    throw DataError(fmt::format("{}, which input_before gives too; a model needs an input that moves", input));
  }
  if (options.input_before || asked.initial_state == InitialState::estimated) return;
  throw DataError(
      fmt::format("{}; a model needs an input that moves. If it stepped at the first row, give its value before: "
                  "--input-before VOLTS (input_before_V in an experiment's [record])",
                  input));
}

// Of max |u|. A record that starts at rest at its largest input has a bias of that size.
constexpr double kGreatestBias = 3.0;

/// Whether the compared samples do not determine the input bias, not even that it is smaller than the input. This
/// happens with a plant of finite DC gain whose start from rest is not compared: the offset then has the effect of the
/// bias.
bool is_bias_lost(const Model& model, double largest_input) {
  const auto bias = std::find_if(model.parameters.begin(), model.parameters.end(),
                                 [](const ParameterEstimate& p) { return p.role == ParameterRole::input_bias; });
  return bias != model.parameters.end() && !bias->fixed &&
         !(std::max(bias->std, std::abs(bias->value) / kGreatestBias) < largest_input);
}

FitResult fit_from(const PreparedRecord& prepared, const StructureOptions& asked, const FitOptions& options,
                   const Executor& executor, const std::vector<Model>& known,
                   const std::vector<FittedStructure>& structures) {
  FitResult result = fit_by_default(prepared, asked, options, executor, known);
  StructureOptions fitted = asked;
  const StructureParameter& bias = asked.structure.input_map.bias;
  if (find_request(asked, bias) == nullptr && is_bias_lost(result.model, prepared.record.input.cwiseAbs().maxCoeff())) {
    fitted.parameters.push_back({bias.key.name, true, 0.0, {}, {}});
    const WorkByStage before = result.work;
    result = fit_by_default(prepared, fitted, options, executor, known);
    add(result.work, before);
    result.model.provenance["input_bias"] =
        "fixed at 0: in the compared samples a constant input cannot be told apart from the offset";
  }
  if (options.intervals == IntervalMethod::profile) {
    note_left_out(result, prepared, fitted, options, executor, structures);
  }
  result.model.structure = std::move(fitted);
  return result;
}

/// All rows of a record after the discarded ones, as they are compared.
Comparison whole_comparison(const Record& record, const FitOptions& options) {
  check_record(record, options);
  const std::size_t discard = discarded_rows(options.discard_s, record.step_s);
  const Comparison comparison = compare_every(static_cast<std::size_t>(record.input.size()),
                                              static_cast<std::size_t>(options.decimation), discard);
  if (comparison.count < 2) throw DataError("record: too few rows are left to score the model on");
  return comparison;
}

Model without_past(Model model) {
  model.past_input.clear();  // it was that of another record
  return model;
}

}  // namespace

FitResult fit(const PreparedRecord& prepared, const StructureOptions& wanted, const FitOptions& options,
              const Executor& executor, const std::vector<Model>& known, const FitProgress& progress) {
  InsideFits inside(prepared, options, executor);
  return fit(prepared, wanted, options, executor, known, progress, inside);
}

FitResult fit(const PreparedRecord& prepared, const StructureOptions& wanted, const FitOptions& options,
              const Executor& executor, const std::vector<Model>& known, const FitProgress& progress,
              InsideFits& inside) {
  const StructureOptions asked = with_sides_of(prepared.record.input, wanted);
  check_input(prepared.record, asked, options);
  if (asked.structure.grey_box) {
    if (progress) progress(0.0, asked.name);
    return fit_grey_box(prepared, asked, options, executor, known);
  }
  if (options.search == Search::local || !known.empty()) {
    return fit_from(prepared, asked, options, executor, known, {});
  }
  const Work work_inside = inside.fit(asked, progress);
  FitResult result = fit_from(prepared, asked, options, executor, inside.models(), inside.structures());
  result.work["inside"] += work_inside;
  inside.take(asked, result.model);
  return result;
}

FitResult fit(const Record& record, const StructureOptions& wanted, const FitOptions& options, const Executor& executor,
              const std::vector<Model>& known, const FitProgress& progress) {
  check_record(record, options);
  const StructureOptions asked = with_sides_of(record.input, wanted);
  check_input(record, asked, options);
  if (options.procedure == Procedure::paper && !asked.structure.grey_box) {
    if (options.input_before) {
      throw ConfigError(
          "input_before: the paper's procedure begins each part with zero history; leave out one of the two");
    }
    FitResult result = fit_by_paper(record, asked, options);
    result.model.structure = asked;
    return result;
  }
  return fit(PreparedRecord(record, options), asked, options, executor, known, progress);
}

ValidationReport validate(const Model& model, const Record& record, const FitOptions& options) {
  const Comparison comparison = whole_comparison(record, options);
  OutputOnRecord outputs(record, comparison);
  FitResult result;
  result.model = begun_on(without_past(model), outputs);
  fill_validation(result, SignalFacts(record), comparison, Effects::include);
  return *result.model.validation;
}

OutputOfModel output_of(const Model& model, const Record& record, const FitOptions& options) {
  const Comparison comparison = whole_comparison(record, options);
  OutputOnRecord outputs(record, comparison);
  const Model scored = begun_on(without_past(model), outputs);
  const ModelOutput output = outputs.of(scored);
  OutputOfModel of{.time_s = row_times(record, comparison.first, comparison.every, comparison.count),
                   .measured = picked(record.output, comparison),
                   .simulated = {}};
  const MeasuredRows& rows = outputs.measured_rows();
  of.simulated = output.total(with_offset_fitted(scored, output.at(rows), rows.of(of.measured)));
  return of;
}

}  // namespace eha::ident
