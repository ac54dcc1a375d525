// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ident/executor.hpp"
#include "ident/output_error/output_error.hpp"
#include "ident/uncertainty/covariance.hpp"

namespace eha::ident {

/// A least-squares optimum in the quantities that a model file reports.
struct ReportedOptimum {
  const ComparedRecord& compared;
  const OutputError& plain;  ///< on the parametrisation to report
  const StructureOptions& structure;
  Parametrisation::Scale scale;
  LinearPart linear;        ///< as in the search
  double bias_bound = 0.0;  ///< max |u| where the bias was a coordinate, else 0 [input unit]
  LinearSolution solution;
  double cost = 0.0;                         ///< sum of squares
  std::vector<ParameterKey> parameters;      ///< as OutputError::derivatives gives them
  std::optional<Autoregression> noise = {};  ///< of `plain`
};

struct Interval {
  double lower = 0.0;
  double upper = 0.0;
};

struct Intervals {
  std::vector<Interval> all;  ///< one a parameter
  Work work;
};

/// Returns 95 % intervals, one a parameter. If the cost is a parabola out to the ends of an interval, the interval is
/// estimate +- factor * standard error. Otherwise it follows from the profile of the cost: its ends are the values at
/// which the least cost over all other parameters has risen as far as that parabola would have at +- factor * standard
/// error. An end that no value reaches is infinite, or the bound of the search if there is one: an order stays between
/// kLowestOrder and kHighestOrder, and a coefficient of a denominator in s or in powers of its own does not fall below
/// 0. No profile is computed for more than 5000 compared samples.
/// Cost: two simulations a parameter; for a profile some ten local fits more.
/// Bates and Watts, Nonlinear Regression Analysis (1988), ch. 6; the rise scaled for a coloured residual: Chandler and
/// Bate, Biometrika 94 (2007).
[[nodiscard]] Intervals intervals(const ReportedOptimum& optimum, const Uncertainty& known, const Executor& executor);

}  // namespace eha::ident
