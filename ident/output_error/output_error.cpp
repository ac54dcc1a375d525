// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/output_error/output_error.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ident/fractional/stability.hpp"
#include "ident/linear_algebra/least_squares_solvers.hpp"
#include "ident/structure/parameter_role.hpp"

namespace eha::ident {
namespace {

// A column that differs by this little from a combination of others is not solved for. Of the responses to a constant
// input, to a step and of the free response one is the sum of the rest, except for the error of their simulation (1e-10
// to 1e-9).
constexpr double kRankThreshold = 1e-8;
constexpr double kNyquist = std::numbers::pi * (1.0 + 1e-9);  // [rad a sample]
// G must fall off: the sampled response of a model with a direct part that moves is not differentiable.
constexpr double kLeastExcess = 1e-3;

double top_order(const std::vector<Term>& terms) {
  double top = 0.0;
  for (const Term& term : terms) top = std::max(top, term.order);
  return top;
}

std::vector<std::vector<Term>> state_numerators(const LinearPart& linear) {
  // The response to an impulse s^i/D is the step response of s^(i+1)/D.
  std::vector<std::vector<Term>> numerators;
  for (int i = 0; i < linear.initial_states; ++i) {
    numerators.push_back({{1.0, static_cast<double>(linear.first_state + i + 1)}});
  }
  return numerators;
}

}  // namespace

OutputError::OutputError(const ComparedRecord& record, const Parametrisation& parametrisation, LinearPart linear,
                         std::optional<Autoregression> noise)
    : record_(record),
      parametrisation_(parametrisation),
      linear_(std::move(linear)),
      noise_(std::move(noise)),
      measured_(seen(record.measured())),
      constant_(seen(Eigen::VectorXd::Ones(record.measured().size()))) {
  for (const Coordinate& c : parametrisation_.coordinates()) {
    bias_coordinate_ = bias_coordinate_ || c.role == CoordinateRole::input_bias;
  }
}

Work OutputError::evaluation_work(std::size_t times) const {
  const std::size_t sides = parametrisation_.has_valve() ? 2 : 0;
  const std::size_t beside = linear_.solve_ratio || linear_.solve_bias ? 2 : 1;
  const std::size_t free =
      linear_.past_shared > 0 ? record_.past().size() : static_cast<std::size_t>(linear_.initial_states);
  Work work;
  work.evaluations = times;
  work.transforms = times * (sides + beside * linear_.numerator.size() + free);
  return work;
}

Work OutputError::jacobian_work() const {
  const std::size_t coordinates = parametrisation_.coordinates().size();
  const bool moves_states = linear_.past_shared == 0 && linear_.initial_states > 0;
  Work work;
  work.jacobians = 1;
  work.transforms = (parametrisation_.has_valve() ? 2 : 0) + (moves_states ? 2 : 1) * coordinates;
  return work;
}

double OutputError::bias_at(const Eigen::VectorXd& theta) const {
  return bias_coordinate_ ? parametrisation_.input_bias(theta) : linear_.fixed_bias;
}

double OutputError::output_energy() const {
  const double level = constant_.dot(measured_) / constant_.squaredNorm();
  return (measured_ - level * constant_).squaredNorm();
}

Eigen::MatrixXd OutputError::seen(Eigen::MatrixXd columns) const {
  if (noise_) return whitened(columns, *noise_);
  return columns;
}

InputSpectrum OutputError::biased(double bias) const {
  InputSpectrum input = record_.input();
  if (bias == 0.0) return input;
  for (std::size_t j = 0; j < input.size(); ++j) input[j] += bias * record_.step()[j];
  return input;
}

InputSpectrum OutputError::Passed::total(double ratio) const {
  InputSpectrum sum = above;
  for (std::size_t j = 0; j < sum.size(); ++j) sum[j] += ratio * below[j];
  return sum;
}

std::shared_ptr<const OutputError::Passed> OutputError::passed(const Eigen::VectorXd& theta) const {
  const std::optional<ValveMap> map = parametrisation_.valve(theta);
  if (!map) return {};
  return std::make_shared<const Passed>(Passed{*map,
                                               record_.spectrum_of(record_.edges().excess_above(upper_edge(*map))),
                                               record_.spectrum_of(record_.edges().excess_below(lower_edge(*map)))});
}

double OutputError::ratio_at(const Passed& valve, const LinearSolution& linear) const {
  return linear_.solve_ratio ? linear.negative_gain_ratio : valve.map.negative_gain_ratio;
}

InputSpectrum OutputError::driving(const std::shared_ptr<const Passed>& valve, const LinearSolution& linear) const {
  return valve ? valve->total(ratio_at(*valve, linear)) : biased(linear.input_bias);
}

/// Derivatives of the map's output by its null, dead band and gain ratio. With A and B the indicators of the two sides:
/// -(A + ratio B), -(A - ratio B), and the output below the dead band for a ratio of 1.
std::vector<InputSpectrum> OutputError::input_derivatives(const Passed& valve, const LinearSolution& linear) const {
  const double ratio = ratio_at(valve, linear);
  const InputSpectrum on_above = record_.spectrum_of(record_.edges().is_above(upper_edge(valve.map)));
  const InputSpectrum on_below = record_.spectrum_of(record_.edges().is_below(lower_edge(valve.map)));
  InputSpectrum by_null(on_above.size());
  InputSpectrum by_dead_band(on_above.size());
  for (std::size_t j = 0; j < on_above.size(); ++j) {
    by_null[j] = -on_above[j] - ratio * on_below[j];
    by_dead_band[j] = -on_above[j] + ratio * on_below[j];
  }
  return {std::move(by_null), std::move(by_dead_band), valve.below};
}

OutputError::Basis OutputError::basis(const TransferFunction& g, const InputSpectrum& input,
                                      const InputSpectrum* beside) const {
  std::vector<std::vector<Term>> numerators;
  for (const Term& term : g.numerator) numerators.push_back({{1.0, term.order}});
  const TransferColumns columns(g, numerators, {});
  std::vector<ResponseRequest> requests;
  for (std::size_t j = 0; j < numerators.size(); ++j) requests.push_back({j, &input});
  for (std::size_t j = 0; beside != nullptr && j < numerators.size(); ++j) requests.push_back({j, beside});
  const Eigen::MatrixXd responses = record_.respond(columns, g.delay_s, requests);
  const auto count = static_cast<Eigen::Index>(numerators.size());
  Basis b{responses.leftCols(count), responses.rightCols(responses.cols() - count),
          Eigen::MatrixXd(responses.rows(), 0)};
  if (linear_.past_shared > 0) {
    std::vector<ResponseRequest> past;
    for (const InputSpectrum& pulse : record_.past()) past.push_back({0, &pulse});
    const Eigen::MatrixXd windows = record_.respond(columns, g.delay_s, past);
    b.states = Eigen::MatrixXd::Zero(windows.rows(), linear_.initial_states);
    for (Eigen::Index k = 0; k < windows.cols(); ++k) b.states.col(shared_index(k)) += windows.col(k);
  } else if (linear_.initial_states > 0) {
    const TransferColumns states(g, state_numerators(linear_), {});
    std::vector<ResponseRequest> free;
    for (std::size_t i = 0; i < states.columns(); ++i) free.push_back({i, &record_.step(), AtJump::after});
    b.states = record_.respond(states, 0.0, free);
  }
  return b;
}

Eigen::Index OutputError::shared_index(Eigen::Index window) const {
  return window / static_cast<Eigen::Index>(linear_.past_shared);
}

Eigen::VectorXd OutputError::free_response(const Basis& basis, const LinearSolution& linear) const {
  if (basis.states.cols() == 0) return Eigen::VectorXd::Zero(basis.numerator.rows());
  return basis.states * linear.initial_state * (linear_.past_shared > 0 ? linear.numerator[0] : 1.0);
}

LinearSolution OutputError::solve(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, double bias,
                                  Eigen::MatrixXd* orthonormal) const {
  // Column order: numerator terms, bias or gain ratio, initial output, initial states.
  const auto terms = static_cast<Eigen::Index>(linear_.numerator.size());
  std::vector<LinearQuantity> quantities = linear_.numerator;
  if (linear_.solve_bias || linear_.solve_ratio) quantities.push_back({});
  quantities.push_back(linear_.initial_output);
  quantities.resize(static_cast<std::size_t>(columns.cols()));

  Eigen::VectorXd x(columns.cols());
  std::vector<bool> held(quantities.size());
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    held[k] = quantities[k].fixed;
    x[static_cast<Eigen::Index>(k)] = quantities[k].fixed ? quantities[k].value : 0.0;
  }
  for (std::size_t round = 0; round <= quantities.size(); ++round) {
    std::vector<Eigen::Index> free;
    Eigen::VectorXd rest = target;
    for (std::size_t k = 0; k < quantities.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      if (!held[k]) {
        free.push_back(i);
      } else if (x[i] != 0.0) {
        rest -= x[i] * columns.col(i);
      }
    }
    if (orthonormal != nullptr) orthonormal->resize(columns.rows(), 0);
    if (free.empty()) break;
    const Eigen::MatrixXd chosen = columns(Eigen::all, free);
    const Eigen::VectorXd scale = chosen.colwise().norm().cwiseMax(1e-300).cwiseInverse();
    const Eigen::MatrixXd a = chosen * scale.asDiagonal();
    const Eigen::VectorXd solved = scale.cwiseProduct(solve_ranked(a, rest, kRankThreshold, orthonormal));
    // The quantity furthest outside its bounds is held at the bound it passed, one a round.
    double worst = 0.0;
    Eigen::Index passed = -1;
    for (std::size_t f = 0; f < free.size(); ++f) {
      const Eigen::Index i = free[f];
      x[i] = solved[static_cast<Eigen::Index>(f)];
      const LinearQuantity& q = quantities[static_cast<std::size_t>(i)];
      const double excess = std::max(q.lower - x[i], x[i] - q.upper);
      if (excess > worst) {
        worst = excess;
        passed = i;
      }
    }
    if (passed < 0) break;
    const LinearQuantity& q = quantities[static_cast<std::size_t>(passed)];
    x[passed] = std::clamp(x[passed], q.lower, q.upper);
    held[static_cast<std::size_t>(passed)] = true;
  }
  LinearSolution solution;
  solution.numerator = x.head(terms);
  Eigen::Index at = terms;
  solution.input_bias = bias;
  if (linear_.solve_bias) {
    const double gain = solution.numerator[0];
    solution.input_bias = gain == 0.0 ? 0.0 : x[at] / gain;
    ++at;
  }
  if (linear_.solve_ratio) {
    const double gain = solution.numerator[0];
    solution.negative_gain_ratio = gain == 0.0 ? 0.0 : x[at] / gain;
    ++at;
  }
  solution.initial_output = x[at++];
  solution.initial_state = x.tail(x.size() - at);
  if (linear_.past_shared > 0) {
    const double gain = solution.numerator[0];
    solution.initial_state *= gain == 0.0 ? 0.0 : 1.0 / gain;
  }
  return solution;
}

Eigen::MatrixXd OutputError::coordinate_derivatives(const Eigen::VectorXd& theta, const LinearSolution& linear,
                                                    const std::shared_ptr<const Passed>& valve) const {
  const TransferFunction g = parametrisation_.transfer_function(theta, linear.numerator);
  const std::vector<Sensitivity> sensitivities = parametrisation_.sensitivities(theta, g);
  const TransferColumns columns(g, {g.numerator}, sensitivities);
  InputSpectrum input = driving(valve, linear);
  for (std::size_t k = 0; linear_.past_shared > 0 && k < record_.past().size(); ++k) {
    const double value = linear.initial_state[shared_index(static_cast<Eigen::Index>(k))];
    for (std::size_t j = 0; j < input.size(); ++j) input[j] += value * record_.past()[k][j];
  }
  const std::vector<InputSpectrum> by_map = valve ? input_derivatives(*valve, linear) : std::vector<InputSpectrum>{};
  std::vector<ResponseRequest> requests;
  for (std::size_t l = 0; l < sensitivities.size(); ++l) {
    // Bias and map move the input, not G: a column is the model's response to the input's change, a step for the bias.
    const CoordinateRole role = parametrisation_.coordinates()[l].role;
    const InputSpectrum* moved = role == CoordinateRole::input_bias            ? &record_.step()
                                 : role == CoordinateRole::valve_null          ? &by_map[0]
                                 : role == CoordinateRole::dead_band           ? &by_map[1]
                                 : role == CoordinateRole::negative_gain_ratio ? &by_map[2]
                                                                               : nullptr;
    requests.push_back(moved != nullptr ? ResponseRequest{0, moved} : ResponseRequest{l + 1, &input});
  }
  Eigen::MatrixXd jacobian = record_.respond(columns, g.delay_s, requests);
  if (linear_.past_shared == 0 && linear.initial_state.size() > 0) {
    TransferFunction free{{}, g.denominator, 0.0};
    for (Eigen::Index i = 0; i < linear.initial_state.size(); ++i) {
      free.numerator.push_back({linear.initial_state[i], static_cast<double>(linear_.first_state + i + 1)});
    }
    std::vector<Sensitivity> by_denominator = sensitivities;
    for (Sensitivity& s : by_denominator) {
      s.numerator.clear();
      s.delay = 0.0;
    }
    const TransferColumns states(free, {}, by_denominator);
    for (std::size_t l = 0; l < requests.size(); ++l) requests[l] = {l, &record_.step(), AtJump::after};
    jacobian += record_.respond(states, 0.0, requests);
  }
  return jacobian;
}

std::optional<OutputError::Point> OutputError::evaluate(const Eigen::VectorXd& theta) const {
  const TransferFunction g = parametrisation_.transfer_function(theta, {});
  if (top_order(g.numerator) >
      top_order(g.denominator) - (parametrisation_.must_be_strictly_proper() ? kLeastExcess : 0.0))
    return {};
  if (grows(g)) return {};
  // Samples do not distinguish an oscillation above the Nyquist frequency from its alias below; the alias is reported.
  if (parametrisation_.fastest_oscillation(theta) > kNyquist / record_.response().step_s()) return {};
  const double bias = bias_at(theta);
  const std::shared_ptr<const Passed> valve = passed(theta);
  const InputSpectrum input = !valve                ? biased(bias)
                              : linear_.solve_ratio ? valve->above
                                                    : valve->total(valve->map.negative_gain_ratio);
  const InputSpectrum* beside = linear_.solve_ratio ? &valve->below : linear_.solve_bias ? &record_.step() : nullptr;
  Basis b = basis(g, input, beside);
  if (noise_) b = {seen(b.numerator), seen(b.beside), seen(b.states)};
  Eigen::MatrixXd columns(measured_.size(), b.numerator.cols() + b.beside.cols() + 1 + b.states.cols());
  columns << b.numerator, b.beside, constant_, b.states;
  if (!columns.allFinite()) return {};
  Point point;
  point.linear = solve(columns, measured_, bias, &point.orthonormal);
  point.residual = measured_ - b.numerator * point.linear.numerator;
  point.residual -= point.linear.initial_output * constant_;
  if (valve && !linear_.solve_ratio) point.linear.negative_gain_ratio = valve->map.negative_gain_ratio;
  if (b.beside.cols() > 0) {
    const double share = linear_.solve_ratio ? point.linear.negative_gain_ratio : point.linear.input_bias;
    point.residual -= share * point.linear.numerator[0] * b.beside.col(0);
  }
  point.residual -= free_response(b, point.linear);
  point.cost = point.residual.squaredNorm();
  point.passed = valve;
  return point;
}

bool OutputError::complete(const Eigen::VectorXd& theta, Point& point) const {
  point.jacobian = seen(coordinate_derivatives(theta, point.linear, point.passed));
  point.jacobian -= point.orthonormal * (point.orthonormal.transpose() * point.jacobian);
  return point.jacobian.allFinite();
}

Eigen::VectorXd OutputError::residual(const Eigen::VectorXd& theta, const LinearSolution& linear) const {
  return seen(record_.measured() - simulated(theta, linear));
}

Eigen::VectorXd OutputError::simulated(const Eigen::VectorXd& theta, const LinearSolution& linear) const {
  const InputSpectrum input = driving(passed(theta), linear);
  const Basis b = basis(parametrisation_.transfer_function(theta, linear.numerator), input, nullptr);
  const Eigen::VectorXd y = b.numerator * linear.numerator + free_response(b, linear);
  return y.array() + linear.initial_output;
}

Eigen::MatrixXd OutputError::derivatives(const Eigen::VectorXd& theta, const LinearSolution& linear,
                                         std::vector<ParameterKey>& parameters) const {
  parameters.clear();
  for (const Coordinate& c : parametrisation_.coordinates()) parameters.push_back(c.key);
  const std::shared_ptr<const Passed> valve = passed(theta);
  const Eigen::MatrixXd nonlinear = coordinate_derivatives(theta, linear, valve);
  const Basis b = basis(parametrisation_.transfer_function(theta, linear.numerator), driving(valve, linear),
                        valve ? &valve->below : &record_.step());
  std::vector<Eigen::VectorXd> columns;
  for (std::size_t j = 0; j < linear_.numerator.size(); ++j) {
    if (linear_.numerator[j].fixed) continue;
    parameters.push_back(numerator_key(j, linear_.numerator.size()));
    columns.emplace_back(b.numerator.col(static_cast<Eigen::Index>(j)));
    // The gain acts on the past input, too.
    if (linear_.past_shared > 0) columns.back() += b.states * linear.initial_state;
  }
  if (linear_.solve_bias || linear_.solve_ratio) {
    parameters.push_back(linear_.solve_ratio ? negative_gain_ratio_key() : input_bias_key());
    columns.emplace_back(b.beside * linear.numerator);
  }
  if (!linear_.initial_output.fixed) {
    parameters.push_back(initial_output_key());
    columns.emplace_back(Eigen::VectorXd::Ones(record_.measured().size()));
  }
  for (Eigen::Index i = 0; i < linear.initial_state.size(); ++i) {
    const auto index = static_cast<std::size_t>(i);
    parameters.push_back(linear_.past_shared > 0 ? past_input_key(index) : state_key(index));
    columns.emplace_back(b.states.col(i) * (linear_.past_shared > 0 ? linear.numerator[0] : 1.0));
  }
  Eigen::MatrixXd all(record_.measured().size(), nonlinear.cols() + static_cast<Eigen::Index>(columns.size()));
  all.leftCols(nonlinear.cols()) = nonlinear;
  for (std::size_t k = 0; k < columns.size(); ++k)
    all.col(nonlinear.cols() + static_cast<Eigen::Index>(k)) = columns[k];
  return seen(std::move(all));
}

}  // namespace eha::ident
