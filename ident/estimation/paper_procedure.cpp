// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/paper_procedure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "core/error.hpp"
#include "ident/estimation/fit_report.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/validation/score.hpp"

namespace eha::ident {
namespace {

constexpr Eigen::Index kFewestPaperRows = 21;  // one more than the lags of a residual's correlation
constexpr int kMaxEvaluations = 400;

/// One part of the decimated record, shifted to start at zero.
struct Part {
  Eigen::VectorXd input;
  Eigen::VectorXd output;
};

enum class Stage { coefficients, orders };

/// Residual as Eigen's solvers want it; x holds K, a2, a1, a0 or n2, n1, n0, b0.
struct Residual {
  using Scalar = double;
  using InputType = Eigen::VectorXd;
  using ValueType = Eigen::VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  const Part& part;
  double step_s;
  Stage stage;
  TransferFunction g;

  [[nodiscard]] int inputs() const { return 4; }
  [[nodiscard]] int values() const { return static_cast<int>(part.output.size()); }

  [[nodiscard]] TransferFunction at(const Eigen::VectorXd& x) const {
    TransferFunction trial = g;
    if (stage == Stage::coefficients) {
      trial.numerator[0].coefficient = x[0];
      for (Eigen::Index i = 0; i < 3; ++i) trial.denominator[static_cast<std::size_t>(i)].coefficient = x[i + 1];
    } else {
      // An order below its bound counts as the bound.
      for (Eigen::Index i = 0; i < 3; ++i) trial.denominator[static_cast<std::size_t>(i)].order = std::max(x[i], 0.0);
      trial.numerator[0].order = std::max(x[3], 0.0);
    }
    return trial;
  }

  int operator()(const Eigen::VectorXd& x, Eigen::VectorXd& residual) const {
    residual = part.output;
    const TransferFunction trial = at(x);
    const double step_power = std::abs(trial.denominator[0].coefficient) + std::abs(trial.denominator[1].coefficient) +
                              std::abs(trial.denominator[2].coefficient);
    if (step_power > 0.0) residual -= simulate(trial, part.input, step_s, SimulationMethod::gl1);
    // A trial that grows beyond all numbers is as bad as a cost can be, but comparable.
    for (double& e : residual) e = std::isfinite(e) ? std::clamp(e, -1e100, 1e100) : 1e100;
    return 0;
  }
};

struct StageResult {
  TransferFunction g;
  int evaluations = 0;
  bool converged = false;
};

StageResult levenberg_marquardt(const Part& part, double step_s, Stage stage, const TransferFunction& start) {
  Eigen::VectorXd x(4);
  if (stage == Stage::coefficients) {
    x << start.numerator[0].coefficient, start.denominator[0].coefficient, start.denominator[1].coefficient,
        start.denominator[2].coefficient;
  } else {
    x << start.denominator[0].order, start.denominator[1].order, start.denominator[2].order, start.numerator[0].order;
  }
  Eigen::NumericalDiff<Residual> functor(Residual{part, step_s, stage, start});
  Eigen::LevenbergMarquardt<Eigen::NumericalDiff<Residual>> solver(functor);
  solver.parameters.maxfev = kMaxEvaluations;
  const auto status = solver.minimize(x);
  const bool converged = status == Eigen::LevenbergMarquardtSpace::RelativeReductionTooSmall ||
                         status == Eigen::LevenbergMarquardtSpace::RelativeErrorTooSmall ||
                         status == Eigen::LevenbergMarquardtSpace::RelativeErrorAndReductionTooSmall ||
                         status == Eigen::LevenbergMarquardtSpace::CosinusTooSmall;
  return {functor.at(x), static_cast<int>(solver.nfev + 4 * solver.njev), converged};
}

Eigen::VectorXd every(const Eigen::VectorXd& signal, Eigen::Index first, Eigen::Index step) {
  return signal(Eigen::seq(first, Eigen::last, step));
}

Part part_of(const Eigen::VectorXd& u, const Eigen::VectorXd& y, Eigen::Index first, Eigen::Index count) {
  Part part{u.segment(first, count), y.segment(first, count)};
  const double start = part.output.size() > 0 ? part.output[0] : 0.0;
  part.output.array() -= start;
  return part;
}

/// Its fractional structure starts at these orders.
constexpr double kFirstHighOrder = 1.8;
constexpr double kFirstLowOrder = 0.9;

/// K, a2, a1, a0 at orders 2, 1, 0, then for a fractional structure the orders alone.
StageResult estimate(const Part& part, double step_s, bool fractional) {
  const TransferFunction ones{{{1.0, 0.0}}, {{1.0, 2.0}, {1.0, 1.0}, {1.0, 0.0}}, 0.0};
  StageResult found = levenberg_marquardt(part, step_s, Stage::coefficients, ones);
  if (!fractional) return found;
  TransferFunction start = found.g;
  start.denominator[0].order = kFirstHighOrder;
  start.denominator[1].order = kFirstLowOrder;
  const int evaluations = found.evaluations;
  found = levenberg_marquardt(part, step_s, Stage::orders, start);
  found.evaluations += evaluations;
  return found;
}

/// Free coefficients but the normalised one, and nothing else of this structure held or bound.
bool has_free_coefficients(const Structure& structure) {
  const auto is_free = [](const StructureTerm& term) { return term.coefficient.freedom == Freedom::free; };
  const auto normalised = static_cast<std::ptrdiff_t>(normalised_index(structure.denominator.size()));
  return std::all_of(structure.denominator.begin(), structure.denominator.begin() + normalised, is_free) &&
         std::all_of(structure.denominator.begin() + normalised + 1, structure.denominator.end(), is_free) &&
         std::all_of(structure.numerator.begin(), structure.numerator.end(), is_free);
}

bool is_plain(const StructureParameter& delay) {
  return delay.freedom != Freedom::free && std::abs(delay.value) <= 0.0;
}

/// K, a2, a1, a0, n2, n1, n0, b0, all of them estimated as far as the procedure knows.
void list_parameters(Model& model) {
  Model rising = model;
  std::reverse(rising.transfer_function.denominator.begin(), rising.transfer_function.denominator.end());
  for (ParameterEstimate& parameter : listed_values(structures::fo(), rising)) {
    const bool of_g = parameter.role != ParameterRole::delay && !is_offset(parameter.role);
    parameter.fixed = false;
    if (of_g) model.parameters.push_back(std::move(parameter));
  }
}

/// Simulates and scores both parts, each from zero history. @param u, y  the kept samples
void score_parts(FitResult& result, const TransferFunction& g, double step_s, const Eigen::VectorXd& u,
                 const Eigen::VectorXd& y) {
  const auto rows = static_cast<Eigen::Index>(result.estimation_samples);
  const Part estimation = part_of(u, y, 0, rows);
  const Eigen::VectorXd estimated = simulate(g, estimation.input, step_s, SimulationMethod::gl1);
  result.model.estimation->score = score(estimation.output, estimated);
  result.measured = y;
  result.simulated = y;
  result.simulated.head(rows) = estimated.array() + y[0];
  if (y.size() - rows < kFewestPaperRows) return;
  const Part validation = part_of(u, y, rows, y.size() - rows);
  const Eigen::VectorXd simulated = simulate(g, validation.input, step_s, SimulationMethod::gl1);
  result.simulated.tail(y.size() - rows) = simulated.array() + y[rows];
  result.model.validation = residual_report(validation.output, simulated, validation.input);
}

}  // namespace

std::optional<Structure> published_structure(const Structure& structure) {
  if (structure.input_map.valve) return {};
  const bool has_terms = structure.denominator.size() == 3 && structure.numerator.size() == 1;
  if (!has_terms || structure.base_order || !has_free_coefficients(structure)) return {};
  if (has_finite_state(structure)) return structures::io();
  const bool orders_free = structure.denominator[1].order.freedom == Freedom::free &&
                           structure.denominator[2].order.freedom == Freedom::free &&
                           structure.denominator[0].order.freedom == Freedom::constant;
  return orders_free ? std::optional(structures::fo()) : std::nullopt;
}

FitResult fit_by_paper(const Record& record, const StructureOptions& asked, const FitOptions& options) {
  const auto published = published_structure(asked.structure);
  if (!published) {
    throw ConfigError(
        fmt::format("model {}: the paper's procedure knows io with two poles and no zero, and fo, without an input "
                    "map; use --procedure default",
                    asked.name));
  }
  if (!asked.parameters.empty() || !is_plain(asked.structure.delay)) {
    throw ConfigError(fmt::format(
        "model {}: the paper's procedure frees and fixes what the paper does and has no delay; use --procedure default",
        asked.name));
  }
  const auto discard = static_cast<Eigen::Index>(discarded_rows(options.discard_s, record.step_s));
  const double step_s = record.step_s * options.decimation;
  if (discard >= record.input.size()) throw DataError("record: shorter than the time to discard");
  const Eigen::VectorXd u = every(record.input, discard, options.decimation);
  const Eigen::VectorXd y = every(record.output, discard, options.decimation);
  const auto rows = static_cast<Eigen::Index>(std::lround(options.split * static_cast<double>(y.size())));
  if (rows < kFewestPaperRows) {
    throw DataError(
        fmt::format("record: {} rows are left to estimate from; expected at least {}", rows, kFewestPaperRows));
  }
  const StageResult found = estimate(part_of(u, y, 0, rows), step_s, !has_finite_state(*published));

  FitResult result = begin_report(record, asked.name, "paper", found.g,
                                  {.work = {{"search", {.evaluations = static_cast<std::size_t>(found.evaluations)}}},
                                   .termination = found.converged ? "converged" : "no further progress",
                                   .converged = found.converged});
  Model& model = result.model;
  model.estimation->compared_step_s = step_s;
  // The paper subtracts the part's first value; this is the one that puts the model on the record.
  model.initial_output = y[0];
  model.provenance["normalisation"] = "none: scale and a common shift of all orders are free, as published";
  model.provenance["neglects"] =
      "the hold of the input between kept samples, all history before each part, input bias and initial state; orders "
      "come out too high and drift looks like dynamics";
  list_parameters(model);
  result.estimation_samples = static_cast<std::size_t>(rows);
  result.time_s = row_times(record, static_cast<std::size_t>(discard), static_cast<std::size_t>(options.decimation),
                            static_cast<std::size_t>(y.size()));
  score_parts(result, found.g, step_s, u, y);
  return result;
}

}  // namespace eha::ident
