// SPDX-License-Identifier: GPL-3.0-or-later
// The parts that every procedure puts its report together from.
#pragma once

#include <string>

#include "ident/estimation/fit.hpp"
#include "ident/estimation/fit_choice.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/validation/residual_tests.hpp"
#include "ident/validation/signal_facts.hpp"

namespace eha::ident {

/// End of a search.
struct SearchEnd {
  WorkByStage work;
  std::string termination;
  bool converged = false;
};

/// A report with the model's name, procedure, units, transfer function and stability, and how the search ended.
[[nodiscard]] FitResult begin_report(const Record& record, const std::string& name, const std::string& procedure,
                                     const TransferFunction& g, const SearchEnd& end);

/// Times of `count` rows of a record: first, first + every, ... [s]
[[nodiscard]] Eigen::VectorXd row_times(const Record& record, std::size_t first, std::size_t every, std::size_t count);

/// Scores the measured rows of one part of a record and correlates its residual with itself and with the input, at up
/// to 20 lags.
[[nodiscard]] ValidationReport residual_report(const Eigen::VectorXd& measured, const Eigen::VectorXd& simulated,
                                               const Eigen::VectorXd& input, const MeasuredRows& rows = {});

/// The values of a structure's listed parameters, without uncertainty, each marked as fixed.
/// @param model  with its transfer function's terms by rising order
[[nodiscard]] std::vector<ParameterEstimate> listed_values(const Structure& structure, const Model& model);

/// Adds the free response to the listed parameters, each value marked as fixed.
void add_free_response(std::vector<ParameterEstimate>& parameters, const Model& model);

struct Normalised {
  TransferFunction g;
  double divisor;
};

/// Orders rising, the coefficient of the second lowest one 1.
[[nodiscard]] Normalised normalised(TransferFunction g);

/// The linear quantities as a model file names them, and `solution` in their terms. A free response that starts with
/// the step response of 1/D holds the offset and the state: sum c_i s^i/D with c_i = x_i + initial_output a_i.
[[nodiscard]] LinearPart as_reported(const LocalOptimum& optimum, const TransferFunction& g, LinearSolution& solution);

/// Simulates result.model over the compared rows and scores it: the estimating ones into `estimation`, the rest into
/// `validation`.
void fill_validation(FitResult& result, const SignalFacts& facts, const Comparison& comparison, Effects effects);

/// Stores the noise of the compared samples: its colour from the validating part, or from the estimating one where all
/// samples estimate.
/// @param with_parameters  whether the parameters were estimated beside a model of the noise
void fill_noise(FitResult& result, const MeasuredRows& rows, bool with_parameters);

/// Inputs of the profiles of the cost, in addition to the optimum.
struct ProfileSearch {
  Parametrisation::Scale scale;
  double largest_input;  ///< max |u|
  const Executor& executor;
};

/// An optimum in the quantities of a model file.
struct ReportedFit {
  const ComparedRecord& compared;
  const LocalOptimum& optimum;
  const LinearPart& linear;        ///< as as_reported() gives it
  const LinearSolution& solution;  ///< the same
  const StructureOptions& asked;
  const Eigen::MatrixXd& input_error;  ///< in the output, at the measured rows; as of input_walk()
};

/// Parameters as the model file lists them, with the uncertainty of the estimated ones, their correlation and the
/// information criteria.
/// @param profile  null: intervals from standard errors alone
void fill_parameters(FitResult& result, const ReportedFit& fit, const ProfileSearch* profile);

}  // namespace eha::ident
