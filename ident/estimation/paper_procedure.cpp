// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/paper_procedure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/NonLinearOptimization>
#include <unsupported/Eigen/NumericalDiff>

#include "core/error.hpp"
#include "ident/fractional/stability.hpp"
#include "ident/validation/correlation.hpp"
#include "ident/validation/score.hpp"

namespace eha::ident {
namespace {

constexpr int kCorrelationLags = 20;
constexpr Eigen::Index kFewestRows = kCorrelationLags + 1;
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

}  // namespace

FitResult fit_by_paper(const Record& record, const StructureOptions& structure, const FitOptions& options) {
  const bool fractional = structure.kind == StructureKind::fo;
  if (!fractional && !(structure.kind == StructureKind::io && structure.poles == 2 && structure.zeros == 0)) {
    throw ConfigError(fmt::format(
        "model {}: the paper's procedure knows io with two poles and no zero, and fo; use --procedure default",
        structure.name));
  }
  if (!structure.parameters.empty() || structure.delay_free || structure.delay_s != 0.0) {
    throw ConfigError(fmt::format(
        "model {}: the paper's procedure frees and fixes what the paper does and has no delay; use --procedure default",
        structure.name));
  }
  const auto discard = static_cast<Eigen::Index>(std::ceil(options.discard_s / record.step_s - 1e-9));
  const double step_s = record.step_s * options.decimation;
  if (discard >= record.input.size()) throw DataError("record: shorter than the time to discard");
  const Eigen::VectorXd u = every(record.input, discard, options.decimation);
  const Eigen::VectorXd y = every(record.output, discard, options.decimation);
  const auto rows = static_cast<Eigen::Index>(std::lround(options.split * static_cast<double>(y.size())));
  if (rows < kFewestRows) {
    throw DataError(fmt::format("record: {} rows are left to estimate from; expected at least {}", rows, kFewestRows));
  }
  const Part estimation = part_of(u, y, 0, rows);

  const TransferFunction ones{{{1.0, 0.0}}, {{1.0, 2.0}, {1.0, 1.0}, {1.0, 0.0}}, 0.0};
  StageResult found = levenberg_marquardt(estimation, step_s, Stage::coefficients, ones);
  int evaluations = found.evaluations;
  if (fractional) {
    TransferFunction start = found.g;
    start.denominator[0].order = 1.8;
    start.denominator[1].order = 0.9;
    found = levenberg_marquardt(estimation, step_s, Stage::orders, start);
    evaluations += found.evaluations;
  }

  FitResult result;
  Model& model = result.model;
  model.name = structure.name;
  model.transfer_function = found.g;
  model.input_unit = record.input_channel.unit;
  model.output_unit = record.output_channel.unit;
  model.procedure = "paper";
  // The paper subtracts the part's first value; this is the one that puts the model on the record.
  model.initial_output = y[0];
  model.stability = stability(found.g);
  model.provenance["normalisation"] = "none: scale and a common shift of all orders are free, as published";
  model.provenance["neglects"] =
      "the hold of the input between kept samples, all history before each part, input bias and initial state; orders "
      "come "
      "out too high and drift looks like dynamics";
  const auto add = [&](const std::string& name, double value) {
    model.parameters.push_back({name, value, 0.0, value, value, false});
  };
  add("K", found.g.numerator[0].coefficient);
  for (std::size_t i = 0; i < 3; ++i) add("a" + std::to_string(2 - i), found.g.denominator[i].coefficient);
  for (std::size_t i = 0; i < 3; ++i) add("n" + std::to_string(2 - i), found.g.denominator[i].order);
  add("b0", found.g.numerator[0].order);

  const Eigen::VectorXd estimated = simulate(found.g, estimation.input, step_s, SimulationMethod::gl1);
  model.estimation.emplace();
  model.estimation->evaluations = static_cast<std::size_t>(evaluations);
  model.estimation->converged = found.converged;
  model.estimation->termination = found.converged ? "converged" : "no further progress";
  model.estimation->score = score(estimation.output, estimated);
  result.estimation_samples = static_cast<std::size_t>(rows);
  result.measured = y;
  result.simulated = y;
  result.simulated.head(rows) = estimated.array() + y[0];
  result.time_s = Eigen::VectorXd::LinSpaced(y.size(), 0.0, static_cast<double>(y.size() - 1)) * step_s;
  result.time_s.array() += record.start_s + static_cast<double>(discard) * record.step_s;
  if (y.size() - rows >= kFewestRows) {
    const Part validation = part_of(u, y, rows, y.size() - rows);
    const Eigen::VectorXd simulated = simulate(found.g, validation.input, step_s, SimulationMethod::gl1);
    const Eigen::VectorXd residual = validation.output - simulated;
    result.simulated.tail(y.size() - rows) = simulated.array() + y[rows];
    ValidationReport report;
    report.score = score(validation.output, simulated);
    report.acf = autocorrelation(residual, kCorrelationLags);
    report.ccf = cross_correlation(residual, validation.input, kCorrelationLags);
    report.ljung_box_p = ljung_box_p(report.acf, static_cast<std::size_t>(residual.size()));
    model.validation = report;
  }
  return result;
}

}  // namespace eha::ident
