// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/fit_report.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/estimation/fit_rows.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/model/earlier_files.hpp"
#include "ident/model/model_output.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/signal/held_levels.hpp"
#include "ident/signal/kept_values.hpp"
#include "ident/signal/rest_at_ends.hpp"
#include "ident/statistics/robust.hpp"
#include "ident/uncertainty/covariance.hpp"
#include "ident/uncertainty/information.hpp"
#include "ident/uncertainty/profile.hpp"
#include "ident/uncertainty/stored_covariance.hpp"
#include "ident/validation/correlation.hpp"
#include "ident/validation/excitation_order.hpp"
#include "ident/validation/input_error.hpp"
#include "ident/validation/map_error.hpp"
#include "ident/validation/record_findings.hpp"
#include "ident/validation/residual_tests.hpp"
#include "ident/validation/score.hpp"
#include "ident/validation/sensor_step.hpp"

namespace eha::ident {
namespace {

constexpr int kCorrelationLags = 20;
constexpr Eigen::Index kShortestStay = 5;
constexpr double kBulgeOverNoise = 3.0;

/// Value of a parameter of a model whose terms stand by rising order.
double value_in(const Model& model, const ParameterKey& key) {
  const TransferFunction& g = model.transfer_function;
  switch (key.role) {
    case ParameterRole::numerator_coefficient:
      return g.numerator.at(key.index).coefficient;
    case ParameterRole::denominator_coefficient:
      return g.denominator.at(key.index).coefficient;
    case ParameterRole::numerator_order:
      return g.numerator.at(key.index).order;
    case ParameterRole::denominator_order:
      return g.denominator.at(key.index).order;
    case ParameterRole::base_order:
      return g.denominator.at(normalised_index(g.denominator.size())).order;
    case ParameterRole::delay:
      return g.delay_s;
    case ParameterRole::input_bias:
      return model.input_bias;
    case ParameterRole::valve_null:
      return model.input_map.value().null;
    case ParameterRole::dead_band:
      return model.input_map.value().dead_band;
    case ParameterRole::negative_gain_ratio:
      return model.input_map.value().negative_gain_ratio;
    case ParameterRole::initial_output:
      return model.initial_output;
    case ParameterRole::grey_box:
      return model.grey_box.value().values.at(key.index);
    case ParameterRole::initial_state:
      return model.initial_state.at(key.index);
    case ParameterRole::past_input:
      break;
  }
  return model.past_input.at(key.index).value;
}

Eigen::VectorXd unfiltered(const Eigen::VectorXd& signal, const Comparison& comparison) {
  return picked(signal, {comparison.first, comparison.every, comparison.count, {}});
}

/// Share of the samples at which the output stays at its greatest or least value for at least kShortestStay samples,
/// while the simulation turns back only beyond that value [%]; 0 unless its bulge, over what it is at the ends of a
/// stay, exceeds kBulgeOverNoise times the white part of the residual on average, and at an end where the output is not
/// as stands_at_end() wants: crests of a coarse sensor; and where it rests at both ends (rests_at_both_ends()). A fit
/// that bends towards the flat pieces still bulges; a plant at rest, or a slow peak of few converter codes, does not.
/// @param output  of the record at the compared rows, without the filter, behind which no two values are equal
/// @param step    of a coarse output, else 0
double saturated_percent(const Eigen::VectorXd& input, const Eigen::VectorXd& output, const Eigen::VectorXd& residual,
                         const Eigen::VectorXd& simulated, double step) {
  if (output.size() <= 2 * kHighestAutoregression || rests_at_both_ends(input, output)) return 0.0;
  double bulge = 0.0;
  Eigen::Index count = 0;
  for (const double extreme : {output.maxCoeff(), output.minCoeff()}) {
    const double side = extreme > output.mean() ? 1.0 : -1.0;
    if (!stands_at_end(output, side)) continue;
    for (Eigen::Index k = 0; k < output.size();) {
      Eigen::Index end = k;
      while (end < output.size() && output[end] == extreme) ++end;
      if (end - k >= kShortestStay) {
        const double at_ends = 0.5 * (simulated[k] + simulated[end - 1]);
        bulge += side * (simulated.segment(k, end - k).array() - at_ends).sum();
        count += end - k;
      }
      k = std::max(end, k + 1);
    }
  }
  if (count == 0 || count == output.size()) return 0.0;
  // The bulges' corners are no noise: they would double its variance.
  const Eigen::MatrixXd white = whitened(residual, autoregression(residual));
  const double noise = robust_std({white.data(), white.data() + white.size()});
  // A motion that settles within the last step of a coarse sensor bulges by less than that.
  if (!(bulge / static_cast<double>(count) > std::max(kBulgeOverNoise * noise, step))) return 0.0;
  return 100.0 * static_cast<double>(count) / static_cast<double>(output.size());
}

/// Share of the samples after the first `estimated` whose input lies outside the range of those [%].
double extrapolated_percent(const Eigen::VectorXd& input, Eigen::Index estimated, bool has_map) {
  const Eigen::Index rest = input.size() - estimated;
  const auto estimating = input.head(estimated);
  const auto [lower, upper] = covered_inputs({estimating.minCoeff(), estimating.maxCoeff()}, has_map);
  const auto outside = (input.tail(rest).array() < lower || input.tail(rest).array() > upper).count();
  return 100.0 * static_cast<double>(outside) / static_cast<double>(rest);
}

Intervals profile_intervals(const ReportedFit& fit, const OutputError& plain,
                            const std::vector<ParameterKey>& parameters, const Uncertainty& known,
                            const ProfileSearch& profile) {
  // With several numerator terms the bias does not enter linearly.
  const bool bias_coordinate =
      fit.optimum.variant.bias_coordinate || (fit.linear.solve_bias && fit.linear.numerator.size() > 1);
  LinearPart searched = fit.linear;
  searched.solve_bias = fit.linear.solve_bias && !bias_coordinate;
  searched.solve_ratio = fit.optimum.variant.linear.solve_ratio;
  const ReportedOptimum optimum{.compared = fit.compared,
                                .plain = plain,
                                .structure = fit.asked,
                                .scale = profile.scale,
                                .linear = searched,
                                .bias_bound = bias_coordinate ? profile.largest_input : 0.0,
                                .solution = fit.solution,
                                .cost = fit.optimum.best.point.cost,
                                .parameters = parameters,
                                .noise = fit.optimum.noise};
  return intervals(optimum, known, profile.executor);
}

}  // namespace

FitResult begin_report(const Record& record, const std::string& name, const std::string& procedure,
                       const TransferFunction& g, const SearchEnd& end) {
  FitResult result;
  Model& model = result.model;
  model.name = name;
  model.procedure = procedure;
  model.transfer_function = g;
  model.input_unit = record.input_channel.unit;
  model.output_unit = record.output_channel.unit;
  model.stability = stability(g);
  model.estimation.emplace();
  model.estimation->evaluations = total(end.work).simulations();
  result.work = end.work;
  model.estimation->termination = end.termination;
  model.estimation->converged = end.converged;
  return result;
}

Eigen::VectorXd row_times(const Record& record, std::size_t first, std::size_t every, std::size_t count) {
  Eigen::VectorXd time_s(static_cast<Eigen::Index>(count));
  for (Eigen::Index j = 0; j < time_s.size(); ++j) {
    time_s[j] = record.start_s + record.step_s * static_cast<double>(first + static_cast<std::size_t>(j) * every);
  }
  return time_s;
}

ValidationReport residual_report(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated,
                                 const Eigen::VectorXd& input, const MeasuredRows& rows) {
  const Eigen::VectorXd residual = measured - simulated;
  const int lags = static_cast<int>(std::min<Eigen::Index>(kCorrelationLags, residual.size() - 1));
  ValidationReport report;
  const Eigen::VectorXd weights = rows.weights(residual.size());
  report.score = score(rows.of(measured), rows.of(simulated));
  report.acf = autocorrelation(residual, lags, weights);
  report.ccf = cross_correlation(residual, input, lags, weights);
  report.ljung_box_p = ljung_box_p(report.acf, correlated_samples(residual.size(), weights));
  return report;
}

std::vector<ParameterEstimate> listed_values(const Structure& structure, const Model& model) {
  std::vector<ParameterEstimate> all;
  for (const StructureParameter* parameter : listed_parameters(structure)) {
    const double value = value_in(model, parameter->key);
    all.push_back({parameter->key.name, value, 0.0, value, value, true, parameter->key.role});
  }
  return all;
}

void add_free_response(std::vector<ParameterEstimate>& parameters, const Model& model) {
  const auto add = [&](const ParameterKey& key) {
    const double value = value_in(model, key);
    parameters.push_back({key.name, value, 0.0, value, value, true, key.role});
  };
  for (std::size_t i = 0; i < model.initial_state.size(); ++i) add(state_key(i));
  for (std::size_t i = 0; i < model.past_input.size(); ++i) add(past_input_key(i));
}

Normalised normalised(TransferFunction g) {
  const auto by_order = [](const Term& a, const Term& b) { return a.order < b.order; };
  std::stable_sort(g.numerator.begin(), g.numerator.end(), by_order);
  std::stable_sort(g.denominator.begin(), g.denominator.end(), by_order);
  const double divisor = g.denominator[normalised_index(g.denominator.size())].coefficient;
  for (Term& term : g.numerator) term.coefficient /= divisor;
  for (Term& term : g.denominator) term.coefficient /= divisor;
  return {std::move(g), divisor};
}

LinearPart as_reported(const LocalOptimum& optimum, const TransferFunction& g, LinearSolution& solution) {
  LinearPart linear = optimum.variant.linear;
  // Reported as a parameter of its own, whether it was solved for or a coordinate.
  linear.solve_bias = linear.solve_bias || optimum.variant.bias_coordinate;
  linear.solve_ratio = false;  // a coordinate of the plain parametrisation
  if (linear.first_state == 0) return linear;
  linear.first_state = 0;
  linear.initial_output.fixed = false;
  const Eigen::VectorXd c = solution.initial_state;
  linear.initial_states = static_cast<int>(c.size()) - 1;
  solution.initial_output = c[0] / g.denominator[0].coefficient;
  solution.initial_state.resize(linear.initial_states);
  for (Eigen::Index i = 1; i < c.size(); ++i) {
    solution.initial_state[i - 1] =
        c[i] - solution.initial_output * g.denominator[static_cast<std::size_t>(i)].coefficient;
  }
  return linear;
}

void fill_validation(FitResult& result, const SignalFacts& facts, const Comparison& comparison, Effects effects) {
  const Record& record = facts.record();
  OutputOnRecord outputs(record, comparison);
  const ModelOutput output = outputs.of(result.model);
  result.measured = picked(record.output, comparison);
  result.simulated = output.total(result.model);
  result.time_s = row_times(record, comparison.first, comparison.every, comparison.count);
  const auto estimated = static_cast<Eigen::Index>(result.estimation_samples);
  const MeasuredRows& all_rows = outputs.measured_rows();
  // A model scored on another record estimates nothing here.
  if (estimated > 0) {
    result.model.estimation->score =
        score(all_rows.of(result.measured.head(estimated)), all_rows.of(result.simulated.head(estimated)));
  }
  const Eigen::Index rest = result.measured.size() - estimated;
  const MeasuredRows rows = all_rows.from(estimated);
  if (rest < 2 || rows.count(rest) < 2) return;
  const ParameterCovariance stored = stored_covariance(result.model);
  const Eigen::VectorXd measured = result.measured.tail(rest);
  const Eigen::VectorXd simulated = result.simulated.tail(rest);
  const Eigen::VectorXd input = picked(record.input, comparison);
  ValidationReport report = residual_report(measured, simulated, input.tail(rest), rows);
  ModelOutput tail{output.forced.tail(rest), Eigen::MatrixXd(output.free.rows() == 0 ? 0 : rest, output.free.cols())};
  if (output.free.cols() > 0) tail.free = output.free.bottomRows(rest);
  tail = tail.at(rows);
  const Eigen::VectorXd scored = rows.of(measured);
  report.offset_reestimated = score(scored, tail.total(with_offset_fitted(result.model, tail, scored)));
  const ParameterCovariance& known = result.covariance.parameters.empty() ? stored : result.covariance;
  report.tests = residual_tests(
      tested_part(result.model, outputs, facts, result.estimation_samples, measured - simulated, known, effects));
  if (const auto levels = two_levels(record.input)) report.input_levels = InputLevels{(*levels)[0], (*levels)[1]};
  report.faster_r2_percent = r2_of_faster_percent(scored, rows.of(simulated));
  const Eigen::VectorXd times_s = all_rows.of(result.time_s);
  const Eigen::VectorXd inputs = all_rows.of(input);
  const Eigen::VectorXd all_measured = all_rows.of(result.measured);
  const Eigen::VectorXd all_simulated = all_rows.of(result.simulated);
  const ComparedRows compared{times_s, inputs, all_measured, all_simulated};
  report.end_stop = end_stop(compared);
  if (!report.end_stop) {
    report.jump = error_burst(compared);
    if (!report.jump) report.jump = error_jump(compared);
  }
  if (report.jump && estimated > 0) report.jump->estimating = report.jump->time_s <= result.time_s[estimated - 1];
  report.saturated_percent =
      std::max(saturated_percent(inputs, all_rows.of(unfiltered(record.output, comparison)),
                                 all_measured - all_simulated, all_simulated, facts.output_step()),
               report.end_stop ? report.end_stop->percent : 0.0);
  const std::optional<ValveMap>& map = result.model.input_map;
  if (effects == Effects::include) {
    report.map_error = map_error(result.model, outputs, result.measured - result.simulated);
  }
  report.sensor_step =
      sensor_step(facts.output_step(), record.output, comparison.taps.empty() ? 1 : static_cast<int>(comparison.every),
                  all_measured - all_simulated);
  // Where only the input that follows goes with what is left over, a controller made its noise, which the plant got.
  const auto& future = report.tests->future_input;
  const bool is_fed_back =
      future && future->degrees > 0 && future->p < kFeedbackLevel && report.tests->input.p >= kFeedbackLevel;
  report.input_noise = input_noise_left_over(result.model, outputs, facts, all_measured - all_simulated);
  // The rounding of a recorded input goes with what follows it, too, as it is part of both.
  if (is_fed_back && report.input_noise && !(report.input_noise->step > 0.0)) report.input_noise.reset();
  report.between_rows = curves_between_rows(result.model, outputs);
  report.excitation_order = excitation_order(map ? mapped(*map, input) : input);
  if (estimated > 0) {
    report.extrapolated_percent = extrapolated_percent(input, estimated, map.has_value());
  }
  result.model.validation = report;
}

void fill_noise(FitResult& result, const MeasuredRows& rows, bool with_parameters) {
  EstimationReport& estimation = result.model.estimation.value();
  const double power = estimation.score.mse;
  if (const auto& validation = result.model.validation) {
    estimation.noise = noise_of(validation->acf, validation->score.samples, power);
  } else {
    const Eigen::VectorXd residual = result.measured - result.simulated;
    const int lags = static_cast<int>(std::min<Eigen::Index>(kCorrelationLags, residual.size() - 1));
    estimation.noise = noise_of(autocorrelation(residual, lags, rows.weights(residual.size())),
                                static_cast<std::size_t>(rows.count(residual.size())), power);
  }
  if (estimation.noise) estimation.noise->with_parameters = with_parameters;
}

void fill_parameters(FitResult& result, const ReportedFit& fit, const ProfileSearch* profile) {
  const Parametrisation plain =
      Parametrisation::plain(fit.asked, result.model.transfer_function, result.model.input_map);
  const OutputError problem(fit.compared, plain, fit.linear, fit.optimum.noise);
  std::vector<ParameterKey> estimated;
  ParameterCorrelation correlation;
  const Eigen::MatrixXd derivatives = problem.derivatives(plain.start(), fit.solution, estimated);
  for (const ParameterKey& key : estimated) correlation.names.push_back(key.name);
  const LeastSquaresResult& best = fit.optimum.best;
  const bool whitens = fit.optimum.noise && fit.input_error.cols() > 0;
  const Eigen::MatrixXd seen = whitens ? whitened(fit.input_error, *fit.optimum.noise) : fit.input_error;
  const Uncertainty known =
      uncertainty(derivatives, correlation.names, residual_model(beyond_errors(best.point.residual, seen)), seen);
  for (Eigen::Index i = 0; i < known.correlation.rows(); ++i) {
    correlation.matrix.emplace_back(known.correlation.row(i).begin(), known.correlation.row(i).end());
  }
  correlation.indistinguishable = known.indistinguishable;
  const Eigen::VectorXd whole = fit.optimum.noise
                                    ? OutputError(fit.compared, fit.optimum.parametrisation, fit.optimum.variant.linear)
                                          .residual(best.theta, best.point.linear)
                                    : best.point.residual;
  const Eigen::VectorXd of_plant = beyond_errors(whole, fit.input_error);
  result.model.estimation->information =
      information(of_plant, fit.compared.measured(), fit.optimum.free, residual_model(of_plant).effective_samples);

  std::vector<Interval> reach;
  if (profile != nullptr) {
    Intervals found = profile_intervals(fit, problem, estimated, known, *profile);
    reach = std::move(found.all);
    result.work["intervals"] += found.work;
    result.model.estimation->evaluations += found.work.simulations();
  }
  result.model.parameters = listed_values(fit.asked.structure, result.model);
  add_free_response(result.model.parameters, result.model);
  for (ParameterEstimate& p : result.model.parameters) {
    const auto at = std::find(correlation.names.begin(), correlation.names.end(), p.name);
    if (at == correlation.names.end()) continue;
    const auto i = static_cast<Eigen::Index>(at - correlation.names.begin());
    p.fixed = false;
    const auto& lost = known.indistinguishable;
    const bool is_lost = std::find(lost.begin(), lost.end(), p.name) != lost.end();
    p.std = is_lost ? std::numeric_limits<double>::infinity() : std::sqrt(known.covariance(i, i));
    const double half_width = known.interval_factor * p.std;
    const Interval straight{std::max(p.value - half_width, least_value(p.role)), p.value + half_width};
    const Interval interval = reach.empty() ? straight : reach[static_cast<std::size_t>(i)];
    p.lower95 = interval.lower;
    p.upper95 = interval.upper;
  }
  result.covariance = {estimated, known.covariance};
  result.model.estimation->correlation = std::move(correlation);
}

}  // namespace eha::ident
