// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/optimum_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "ident/estimation/fit_report.hpp"
#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/valve_starts.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/model_output.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/structure/parameter_requests.hpp"
#include "ident/validation/input_error.hpp"
#include "ident/validation/score.hpp"
#include "ident/validation/sensor_step.hpp"

namespace eha::ident {
namespace {

/// Writes the linear quantities into the model.
void fill_linear(Model& model, const FitAtItsEnd& fit, const LinearPart& reported, const LinearSolution& solution) {
  model.input_bias = solution.input_bias;
  model.initial_output = solution.initial_output;
  if (!wants_past_input(fit.asked)) {
    model.initial_state.assign(solution.initial_state.begin(), solution.initial_state.end());
    return;
  }
  const std::vector<PastInput>& windows = fit.compared.past_windows();
  const std::size_t shared = reported.past_shared;
  for (std::size_t k = 0; k < windows.size(); k += shared) {
    const std::size_t oldest = std::min(k + shared, windows.size()) - 1;
    model.past_input.push_back(
        {windows[oldest].from_s, windows[k].to_s, solution.initial_state[static_cast<Eigen::Index>(k / shared)]});
  }
}

void fill_provenance(Model& model, const FitAtItsEnd& fit, const LinearPart& reported) {
  const Structure& structure = fit.asked.structure;
  const std::size_t scale = normalised_index(structure.denominator.size());
  const StructureParameter& lowest = structure.denominator.front().order;
  const bool lowest_is_0 = structure.base_order || (lowest.freedom == Freedom::constant && lowest.value <= 0.0);
  model.provenance["normalisation"] = structure.denominator[scale].coefficient.key.name + " = 1" +
                                      (lowest_is_0 ? ", lowest order of the denominator 0" : "");
  if (structure.input_map.valve) return;
  const bool bias_is_asked = find_request(fit.given, structure.input_map.bias) != nullptr;
  if (fit.rests_before) {
    model.provenance["input_bias"] = fit.options.input_before
                                         ? "fixed: at rest at the input given for before the record"
                                         : "fixed: a step test that starts at rest at that level";
  } else if (!bias_is_asked && !reported.solve_bias && reported.fixed_bias == 0.0) {
    model.provenance["input_bias"] =
        "fixed at 0: with an initial state a constant input cannot be told apart from offset and state";
  }
}

/// What the optimum leaves of the output, not whitened.
Eigen::VectorXd plain_residual(const LocalOptimum& chosen, const ComparedRecord& compared) {
  if (!chosen.noise) return chosen.best.point.residual;
  return OutputError(compared, chosen.parametrisation, chosen.variant.linear)
      .residual(chosen.best.theta, chosen.best.point.linear);
}

/// Whether the rows at rest belong to so many stays that their errors are noise, whose correlation the residual shows;
/// of few stays it shows too little.
bool are_many(const Eigen::MatrixXd& stays) {
  constexpr double kMany = 8.0;  // of equal length
  const Eigen::ArrayXd rows = stays.colwise().squaredNorm().transpose();
  return rows.sum() * rows.sum() > kMany * rows.square().sum();
}

/// What the error of the recorded input leaves in the output, and what rounding leaves of it, at the measured rows of
/// the estimating part.
Eigen::MatrixXd known_errors_at_estimated(const Model& model, const PreparedRecord& prepared,
                                          const Eigen::VectorXd& residual) {
  Comparison estimating = prepared.rows.comparison;
  estimating.count = prepared.rows.estimating;
  OutputOnRecord outputs(prepared.record, estimating);
  const Eigen::MatrixXd walk = input_walk(model, outputs, 0, residual, prepared.facts.input_error_std());
  Eigen::MatrixXd stays = rounded_stays(prepared.record, prepared.facts.output_step(), estimating, 0);
  if (are_many(stays)) stays.conservativeResize(Eigen::NoChange, 0);
  Eigen::MatrixXd errors(walk.rows(), walk.cols() + stays.cols());
  errors << walk, stays;
  return outputs.measured_rows().of_columns(errors);
}

}  // namespace

FitResult report_of(const LocalOptimum& chosen, const FitAtItsEnd& fit) {
  const Record& record = fit.prepared.record;
  const FitRows& rows = fit.prepared.rows;
  LinearSolution solution = chosen.best.point.linear;
  const Normalised scaled = normalised(chosen.parametrisation.transfer_function(chosen.best.theta, solution.numerator));
  for (Eigen::Index j = 0; j < solution.numerator.size(); ++j) {
    solution.numerator[j] = scaled.g.numerator[static_cast<std::size_t>(j)].coefficient;
  }
  if (!wants_past_input(fit.asked)) solution.initial_state /= scaled.divisor;
  const LinearPart reported = as_reported(chosen, scaled.g, solution);
  const Termination end = chosen.best.termination;
  FitResult result =
      begin_report(record, fit.asked.name, "default", scaled.g,
                   {.work = fit.work, .termination = std::string(text(end)), .converged = has_converged(end)});
  Model& model = result.model;
  if (declares_integrator(fit.asked)) model.stability = stability_beside_integrator(scaled.g);
  model.input_map = valve_of(chosen);
  fill_linear(model, fit, reported, solution);
  fill_provenance(model, fit, reported);
  if (chosen.noise) {
    model.provenance["noise_model"] =
        fmt::format("autoregressive of order {}, estimated beside the parameters", chosen.noise->coefficients.size());
  }
  result.estimation_samples = rows.estimating;
  const ProfileSearch profile{fit.scale, record.input.cwiseAbs().maxCoeff(), fit.executor};
  const bool profiles = fit.options.intervals == IntervalMethod::profile;
  const Eigen::VectorXd residual = plain_residual(chosen, fit.compared);
  const Eigen::MatrixXd input_error = fit.options.reported == Reported::score
                                          ? Eigen::MatrixXd()
                                          : known_errors_at_estimated(model, fit.prepared, residual);
  fill_parameters(result,
                  {.compared = fit.compared,
                   .optimum = chosen,
                   .linear = reported,
                   .solution = solution,
                   .asked = fit.asked,
                   .input_error = input_error},
                  profiles ? &profile : nullptr);
  model.estimation->compared_step_s = record.step_s * static_cast<double>(rows.comparison.every);
  model.estimation->input_range = input_range(record, rows);
  const Eigen::VectorXd& measured = fit.compared.measured();
  model.estimation->score = score(measured, measured - residual);
  // Highest order first, as transfer functions are written.
  std::reverse(model.transfer_function.numerator.begin(), model.transfer_function.numerator.end());
  std::reverse(model.transfer_function.denominator.begin(), model.transfer_function.denominator.end());
  auto fitted = std::make_shared<FittedOptimum>(FittedOptimum{fit.given, fit.asked, fit.scale, chosen});
  fitted->optimum.best.point.jacobian.resize(0, 0);
  fitted->optimum.best.point.orthonormal.resize(0, 0);
  fitted->optimum.best.point.passed.reset();
  result.fitted = std::move(fitted);
  if (fit.options.reported == Reported::everything) {
    complete_report(result, fit.prepared, profiles ? Effects::include : Effects::leave_out);
  }
  return result;
}

void complete_report(FitResult& result, const PreparedRecord& prepared, Effects effects) {
  Model& model = result.model;
  const std::vector<double> frequencies =
      bode_frequencies(result.fitted->scale.duration_s, model.estimation->compared_step_s.value());
  model.bode = bode_curve(model, frequencies, result.covariance);
  fill_validation(result, prepared.facts, prepared.rows.comparison, effects);
  fill_noise(result, MeasuredRows(prepared.record, prepared.rows.comparison), result.fitted->optimum.noise.has_value());
}

bool is_complete(const FitResult& result) { return result.simulated.size() > 0; }

}  // namespace eha::ident
