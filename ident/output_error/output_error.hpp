// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ident/coordinates/parametrisation.hpp"
#include "ident/fractional/held_response.hpp"
#include "ident/model/model.hpp"
#include "ident/record.hpp"
#include "ident/signal/autoregression.hpp"
#include "ident/signal/decimation.hpp"
#include "ident/signal/edge_thinning.hpp"
#include "ident/signal/measured_rows.hpp"
#include "ident/work.hpp"

namespace eha::ident {

/// The parts of a simulation that do not depend on the model, computed once for a record. Immutable, thread-safe.
class ComparedRecord {
 public:
  struct Options {
    bool past = false;       ///< an input before t = 0 is estimated; doubles the simulated length
    double guard = 1.6;      ///< as in HeldResponse
    double resolved = 1e-9;  ///< as in OutputSelection
    /// Rows whose means over blocks of `block` are the record's input. A map before G applies to the rows, not to their
    /// means. Empty: the record's input itself.
    Eigen::VectorXd fine_input = {};
    Eigen::Index block = 1;
    bool keep_input = true;  ///< keep edges(); only a map before G needs it
  };
  /// @param rows  number of the comparison's rows that are used, from the first on
  ComparedRecord(const Record& record, const Comparison& comparison, std::size_t rows, const Options& options);

  [[nodiscard]] const HeldResponse& response() const noexcept { return response_; }
  [[nodiscard]] const InputSpectrum& input() const noexcept { return input_; }
  /// The input of a map, thinned behind it, for spectrum_of(). Precondition: Options::keep_input.
  [[nodiscard]] const EdgeThinning& edges() const { return edges_.value(); }
  /// Spectrum of what one of edges()' functions returned.
  [[nodiscard]] InputSpectrum spectrum_of(const Eigen::VectorXd& thinned) const;
  [[nodiscard]] const InputSpectrum& step() const noexcept { return step_; }  ///< of a unit step at t = 0
  /// Spectra of a unit pulse in each window of the past, the latest window first. The windows double in length,
  /// starting from a 128th of the compared time, and together span that time. An older input has the effect of a
  /// constant.
  [[nodiscard]] const std::vector<InputSpectrum>& past() const noexcept { return past_; }
  [[nodiscard]] const std::vector<PastInput>& past_windows() const noexcept { return past_windows_; }  ///< no values
  /// The output, filtered and picked, at the rows that were measured.
  [[nodiscard]] const Eigen::VectorXd& measured() const noexcept { return measured_; }
  /// As of response(), at the same rows.
  [[nodiscard]] Eigen::MatrixXd respond(const TransferColumns& columns, double delay_s,
                                        std::span<const ResponseRequest> requests) const {
    return rows_.of_columns(response_.respond(columns, delay_s, requests));
  }

 private:
  ComparedRecord(const Record& record, const Comparison& comparison, std::size_t rows, const Options& options,
                 const std::vector<std::size_t>& edges);

  HeldResponse response_;
  std::size_t before_;  ///< rows of the past, at the beginning of the simulation
  Eigen::Index block_;
  std::optional<EdgeThinning> edges_;
  InputSpectrum input_;
  InputSpectrum step_;
  std::vector<InputSpectrum> past_;
  std::vector<PastInput> past_windows_;
  MeasuredRows rows_;
  Eigen::VectorXd measured_;
};

/// A quantity that enters the output linearly.
struct LinearQuantity {
  bool fixed = false;
  double value = 0.0;  ///< when fixed
  double lower = -1e300;
  double upper = 1e300;
};

/// The linear quantities, solved exactly at every trial of the nonlinear coordinates.
struct LinearPart {
  std::vector<LinearQuantity> numerator;  ///< one for each numerator term
  bool solve_bias = false;                ///< solve the input bias with the numerator; single numerator terms only
  double fixed_bias = 0.0;                ///< if neither solved nor a coordinate [input unit]
  /// Solve the gain ratio of a valve map with the numerator, which is the gain above the dead band; single numerator
  /// terms only.
  bool solve_ratio = false;
  LinearQuantity initial_output;
  /// Number of free-response terms: of the initial state, or of the past input if that is estimated (single numerator
  /// terms only).
  int initial_states = 0;
  std::size_t past_shared = 0;  ///< neighbouring windows of the past that share one value; 0 for no past input
  /// Power k of s in the numerator of the first free response, an impulse response s^k/D: 0, or -1 for the step
  /// response of 1/D. With -1 added to the whole state, the free responses span the constant. They stay independent as
  /// D approaches an integrator, where the constant itself and the last state become collinear.
  int first_state = 0;
};

/// The parameters of a model except its nonlinear coordinates.
struct LinearSolution {
  Eigen::VectorXd numerator;
  double input_bias = 0.0;
  double negative_gain_ratio = 1.0;  ///< of the valve map, if there is one
  double initial_output = 0.0;
  Eigen::VectorXd initial_state;  ///< or the past input, window by window [input unit]
};

/// Output error of one structure on one record, with the linear quantities eliminated (variable projection).
///   e = y - initial_output - G(v) - free response,  v = u + bias or valve(u),
/// where the free response is that to an initial state or to an input before t = 0.
/// A noise model whitens rows, residual and derivatives, which lose kHighestAutoregression rows. The cost is then that
/// of generalised least squares.
/// Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973); Kaufman, BIT 15 (1975), for the Jacobian. Thread-safe.
class OutputError {
 public:
  OutputError(const ComparedRecord& record, const Parametrisation& parametrisation, LinearPart linear,
              std::optional<Autoregression> noise = {});

  /// The input behind a valve map, one part for each side of the dead band.
  struct Passed {
    ValveMap map;
    InputSpectrum above;
    InputSpectrum below;
    [[nodiscard]] InputSpectrum total(double ratio) const;
  };

  struct Point {
    double cost = 0.0;         ///< sum of squares
    Eigen::VectorXd residual;  ///< measured less simulated
    Eigen::MatrixXd jacobian;  ///< of the simulated output, projected; empty without complete()
    LinearSolution linear;
    Eigen::MatrixXd orthonormal;           ///< basis of the linear quantities' columns
    std::shared_ptr<const Passed> passed;  ///< null without a map
  };

  /// Work of evaluate() and complete().
  [[nodiscard]] Work evaluation_work(std::size_t times = 1) const;
  [[nodiscard]] Work jacobian_work() const;

  /// Returns nothing if the model at theta grows or is not proper.
  [[nodiscard]] std::optional<Point> evaluate(const Eigen::VectorXd& theta) const;
  /// Adds the Jacobian to the point at theta. @returns whether it is finite
  [[nodiscard]] bool complete(const Eigen::VectorXd& theta, Point& point) const;

  /// Exact derivatives of the simulated output by every free quantity at a given solution, not projected: the
  /// coordinates first, then numerator, input_bias or negative_gain_ratio, initial_output and initial_state if they are
  /// solved for.
  /// @param parameters  receives the parameter of each column
  [[nodiscard]] Eigen::MatrixXd derivatives(const Eigen::VectorXd& theta, const LinearSolution& linear,
                                            std::vector<ParameterKey>& parameters) const;

  /// Measured less simulated at a given solution, whitened where there is a noise model.
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& theta, const LinearSolution& linear) const;

  /// Simulated output at a given solution.
  [[nodiscard]] Eigen::VectorXd simulated(const Eigen::VectorXd& theta, const LinearSolution& linear) const;

  /// Returns sum (y - mean y)^2 of the compared rows, the scale of costs.
  [[nodiscard]] double output_energy() const;

  [[nodiscard]] const Parametrisation& parametrisation() const noexcept { return parametrisation_; }
  [[nodiscard]] const LinearPart& linear() const noexcept { return linear_; }

 private:
  struct Basis {
    Eigen::MatrixXd numerator;  ///< response of each numerator term
    Eigen::MatrixXd beside;     ///< the same for the input that is solved for together with the gain, if any
    Eigen::MatrixXd states;     ///< free responses; to the past input for a gain of 1
  };
  [[nodiscard]] std::shared_ptr<const Passed> passed(const Eigen::VectorXd& theta) const;
  /// @param beside  input that is solved for together with the gain; null for none
  [[nodiscard]] Basis basis(const TransferFunction& g, const InputSpectrum& input, const InputSpectrum* beside) const;
  [[nodiscard]] LinearSolution solve(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, double bias,
                                     Eigen::MatrixXd* orthonormal) const;
  [[nodiscard]] double ratio_at(const Passed& valve, const LinearSolution& linear) const;
  [[nodiscard]] std::vector<InputSpectrum> input_derivatives(const Passed& valve, const LinearSolution& linear) const;
  [[nodiscard]] InputSpectrum driving(const std::shared_ptr<const Passed>& valve, const LinearSolution& linear) const;
  [[nodiscard]] Eigen::MatrixXd coordinate_derivatives(const Eigen::VectorXd& theta, const LinearSolution& linear,
                                                       const std::shared_ptr<const Passed>& valve) const;
  [[nodiscard]] Eigen::Index shared_index(Eigen::Index window) const;
  [[nodiscard]] Eigen::VectorXd free_response(const Basis& basis, const LinearSolution& linear) const;
  [[nodiscard]] InputSpectrum biased(double bias) const;
  [[nodiscard]] double bias_at(const Eigen::VectorXd& theta) const;

  [[nodiscard]] Eigen::MatrixXd seen(Eigen::MatrixXd columns) const;

  const ComparedRecord& record_;
  Parametrisation parametrisation_;
  LinearPart linear_;
  std::optional<Autoregression> noise_;
  Eigen::VectorXd measured_;  ///< whitened like the constant
  Eigen::VectorXd constant_;
  bool bias_coordinate_ = false;
};

}  // namespace eha::ident
