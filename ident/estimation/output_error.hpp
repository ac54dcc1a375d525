// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ident/estimation/parametrisation.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/record.hpp"
#include "ident/signal/decimation.hpp"

namespace eha::ident {

/// A record made ready for many simulations: everything that does not depend on the model. Immutable, thread-safe.
class ComparedRecord {
 public:
  /// @param rows  how many of the comparison's rows are used, from the first on
  /// @param guard, resolved  as in HeldResponse and OutputSelection
  ComparedRecord(const Record& record, const Comparison& comparison, std::size_t rows, double guard = 1.6,
                 double resolved = 1e-9);

  [[nodiscard]] const HeldResponse& response() const noexcept { return response_; }
  [[nodiscard]] const InputSpectrum& input() const noexcept { return input_; }
  [[nodiscard]] const InputSpectrum& step() const noexcept { return step_; }
  [[nodiscard]] const Eigen::VectorXd& measured() const noexcept { return measured_; }  ///< filtered and picked

 private:
  HeldResponse response_;
  InputSpectrum input_;
  InputSpectrum step_;
  Eigen::VectorXd measured_;
};

/// A quantity that enters the output linearly.
struct LinearQuantity {
  bool fixed = false;
  double value = 0.0;  ///< when fixed
  double lower = -1e300;
  double upper = 1e300;
};

/// What is solved for exactly at every trial of the nonlinear coordinates.
struct LinearPart {
  std::vector<LinearQuantity> numerator;  ///< one a numerator term
  bool solve_bias = false;                ///< input bias with the numerator; single numerator terms only
  double fixed_bias = 0.0;                ///< when neither solved nor a coordinate [input unit]
  LinearQuantity initial_output;
  int initial_states = 0;  ///< terms of the free response
  /// Power of s in the numerator of the first free response, an impulse response s^k/D: 0, or -1 for the step response
  /// of 1/D. With that one added to the whole state the constant is among them, and they stay apart when D approaches
  /// an integrator, where the constant itself and the last state run together.
  int first_state = 0;
};

/// All of a model but its nonlinear coordinates.
struct LinearSolution {
  Eigen::VectorXd numerator;
  double input_bias = 0.0;
  double initial_output = 0.0;
  Eigen::VectorXd initial_state;
};

/// Output error of one structure on one record, the linear quantities eliminated (variable projection).
///   e = y - initial_output - G(u + bias) - free response
/// Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973); Kaufman, BIT 15 (1975), for the Jacobian. Thread-safe.
class OutputError {
 public:
  OutputError(const ComparedRecord& record, const Parametrisation& parametrisation, LinearPart linear);

  struct Point {
    double cost = 0.0;         ///< sum of squares
    Eigen::VectorXd residual;  ///< measured less simulated
    Eigen::MatrixXd jacobian;  ///< of the simulated output, projected; empty unless asked for
    LinearSolution linear;
  };

  enum class Want { value, jacobian };

  /// Nothing when the model at theta grows or is not proper.
  [[nodiscard]] std::optional<Point> evaluate(const Eigen::VectorXd& theta, Want want) const;

  /// Exact derivatives of the simulated output by every free quantity at a given solution, not projected: the
  /// coordinates first, then numerator, input_bias, initial_output and initial_state as far as they are solved for.
  [[nodiscard]] Eigen::MatrixXd derivatives(const Eigen::VectorXd& theta, const LinearSolution& linear,
                                            std::vector<std::string>& names) const;

  /// Simulated output at a given solution.
  [[nodiscard]] Eigen::VectorXd simulated(const Eigen::VectorXd& theta, const LinearSolution& linear) const;

  /// sum (y - mean y)^2 of the compared rows: what a cost is small beside.
  [[nodiscard]] double output_energy() const;

  [[nodiscard]] const Parametrisation& parametrisation() const noexcept { return parametrisation_; }
  [[nodiscard]] const LinearPart& linear() const noexcept { return linear_; }

 private:
  struct Basis {
    Eigen::MatrixXd numerator;  ///< response of each numerator term
    Eigen::MatrixXd step;       ///< the same to a unit step
    Eigen::MatrixXd states;     ///< free responses
  };
  [[nodiscard]] Basis basis(const TransferFunction& g, double bias, bool steps) const;
  [[nodiscard]] LinearSolution solve(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, double bias,
                                     Eigen::MatrixXd* orthonormal) const;
  [[nodiscard]] Eigen::MatrixXd coordinate_derivatives(const Eigen::VectorXd& theta,
                                                       const LinearSolution& linear) const;
  [[nodiscard]] InputSpectrum biased(double bias) const;
  [[nodiscard]] double bias_at(const Eigen::VectorXd& theta) const;

  const ComparedRecord& record_;
  Parametrisation parametrisation_;
  LinearPart linear_;
  bool bias_coordinate_ = false;
};

}  // namespace eha::ident
