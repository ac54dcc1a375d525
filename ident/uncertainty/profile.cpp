// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ident/fractional/stability.hpp"
#include "ident/search/least_squares.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// The cost counts as a parabola if its rise differs by less than this share, which moves an end by a tenth.
constexpr double kStraight = 0.2;
constexpr double kEndTolerance = 0.05;  // of the root of the rise
// Of the output's energy: a smaller rise is lost in the rounding of the simulation.
constexpr double kResolvedRise = 1e-14;
constexpr int kMostTrials = 14;  // an end
constexpr double kGreatestStretch = 3.0;
constexpr Eigen::Index kMostRows = 5000;  // a profile would take minutes
// An end is needed to a few percent only.
constexpr LeastSquaresOptions kCoarse{.max_evaluations = 60, .cost_tolerance = 1e-7, .step_tolerance = 1e-6};

double& named(std::vector<ParameterRequest>& requests, const std::string& name) {
  auto at = std::find_if(requests.begin(), requests.end(), [&](const auto& request) { return request.name == name; });
  if (at == requests.end()) at = requests.insert(at, ParameterRequest{name, {}, {}, {}, {}});
  return at->start.emplace();
}

/// Returns the bounds of a parameter in the search.
Interval admissible(const ReportedOptimum& optimum, const std::vector<Coordinate>& searched, const ParameterKey& key) {
  Interval reach{least_value(key.role), kInfinity};
  const auto at = std::find_if(searched.begin(), searched.end(), [&](const auto& c) { return c.key.name == key.name; });
  if (at != searched.end() && (is_order(key.role) || key.role == ParameterRole::delay)) {
    reach = {at->lower, at->upper};
  } else if (key.role == ParameterRole::denominator_coefficient && !optimum.structure.structure.base_order) {
    // Weights, natural frequencies and damping ratios are positive.
    reach.lower = 0.0;
  }
  for (const ParameterRequest& request : optimum.structure.parameters) {
    if (request.name != key.name) continue;
    reach.lower = std::max(reach.lower, request.lower.value_or(reach.lower));
    reach.upper = std::min(reach.upper, request.upper.value_or(reach.upper));
  }
  return reach;
}

/// Converts the optimum's parameters to one vector, and back.
class Reported {
 public:
  explicit Reported(const ReportedOptimum& optimum) : optimum_(optimum) {
    const Eigen::VectorXd theta = optimum.plain.parametrisation().start();
    coordinates_ = theta.size();
    std::vector<double> all(theta.begin(), theta.end());
    visit(optimum.solution, [&](const double& value) { all.push_back(value); });
    values_ = Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
    const std::vector<Coordinate> searched = Parametrisation::search(optimum.structure, optimum.scale).coordinates();
    for (std::size_t i = 0; i < optimum.parameters.size(); ++i) {
      Interval reach = admissible(optimum, searched, optimum.parameters[i]);
      // An optimum on a bound may lie beyond it by rounding.
      const double value = values_[static_cast<Eigen::Index>(i)];
      reach = {std::min(reach.lower, value), std::max(reach.upper, value)};
      reach_.push_back(reach);
    }
  }

  [[nodiscard]] const Eigen::VectorXd& values() const { return values_; }
  [[nodiscard]] const Interval& reach(std::size_t parameter) const { return reach_[parameter]; }

  /// Sum of squares with the parameters at `values`; infinite for a model that grows or exceeds the search's bounds.
  [[nodiscard]] double cost(const Eigen::VectorXd& values) const {
    for (std::size_t i = 0; i < reach_.size(); ++i) {
      const double value = values[static_cast<Eigen::Index>(i)];
      if (value < reach_[i].lower || value > reach_[i].upper) return kInfinity;
    }
    const Eigen::VectorXd theta = values.head(coordinates_);
    LinearSolution linear = optimum_.solution;
    Eigen::Index at = coordinates_;
    visit(linear, [&](double& value) { value = values[at++]; });
    const Parametrisation& plain = optimum_.plain.parametrisation();
    if (grows(plain.transfer_function(theta, linear.numerator))) return kInfinity;
    const double sum = optimum_.plain.residual(theta, linear).squaredNorm();
    return std::isfinite(sum) ? sum : kInfinity;
  }

 private:
  /// Returns the free linear quantities, in the order of OutputError::derivatives.
  template <typename Solution, typename Visit>
  void visit(Solution& solution, const Visit& visit) const {
    const LinearPart& linear = optimum_.plain.linear();
    for (std::size_t j = 0; j < linear.numerator.size(); ++j) {
      if (!linear.numerator[j].fixed) visit(solution.numerator[static_cast<Eigen::Index>(j)]);
    }
    if (linear.solve_bias) visit(solution.input_bias);
    if (!linear.initial_output.fixed) visit(solution.initial_output);
    for (auto& state : solution.initial_state) visit(state);
  }

  const ReportedOptimum& optimum_;
  Eigen::Index coordinates_ = 0;
  Eigen::VectorXd values_;
  std::vector<Interval> reach_;  ///< one a parameter
};

/// One parameter's interval.
class Profile {
 public:
  Profile(const ReportedOptimum& optimum, const Reported& reported, const Uncertainty& known, std::size_t parameter)
      : optimum_(optimum), reported_(reported), key_(optimum.parameters[parameter]), reach_(reported.reach(parameter)) {
    const auto at = static_cast<Eigen::Index>(parameter);
    value_ = reported.values()[at];
    const double unit_variance = known.unit_covariance(at, at);
    direction_ = known.unit_covariance.col(at) / unit_variance;
    half_width_ = known.interval_factor * std::sqrt(known.covariance(at, at));
    rise_ = half_width_ * half_width_ / unit_variance;
  }

  [[nodiscard]] Interval straight() const {
    return {std::max(reach_.lower, value_ - half_width_), std::min(reach_.upper, value_ + half_width_)};
  }

  /// Whether the cost rises as a parabola up to both ends of the straight interval.
  [[nodiscard]] bool is_straight() const {
    if (!(rise_ > kResolvedRise * optimum_.plain.output_energy())) return true;
    if (value_ - half_width_ < reach_.lower || value_ + half_width_ > reach_.upper) return false;
    return std::abs(straight_rise(1.0) / rise_ - 1.0) < kStraight &&
           std::abs(straight_rise(-1.0) / rise_ - 1.0) < kStraight;
  }

  /// Whether a search with the parameter held at its value finds the optimum again. One that does not cannot give a
  /// profile.
  [[nodiscard]] bool finds_optimum() {
    Eigen::VectorXd others = reported_.values();
    return least_cost(value_, others) - optimum_.cost < kStraight * kStraight * rise_;
  }

  /// Finds where the profile has risen by rise_. @param side  -1 or 1
  [[nodiscard]] double end(double side) {
    const double room = side < 0.0 ? value_ - reach_.lower : reach_.upper - value_;
    double distance = std::min(half_width_, room);
    if (!(distance > 0.0)) return value_;
    double inside = 0.0;
    double outside = kInfinity;
    Eigen::VectorXd others = reported_.values();
    for (int trial = 0; trial < kMostTrials; ++trial) {
      // Each search starts from the last optimum inside the interval; one outside may be a poor local optimum.
      Eigen::VectorXd start = others;
      const double rise = least_cost(value_ + side * distance, start) - optimum_.cost;
      const double root = std::sqrt(std::max(0.0, rise) / rise_);
      if (std::abs(root - 1.0) < kEndTolerance) return value_ + side * distance;
      if (root < 1.0) {
        if (distance >= room) return side < 0.0 ? reach_.lower : reach_.upper;
        inside = distance;
        others = start;
      } else {
        outside = distance;
      }
      distance *= std::clamp(1.0 / root, 1.0 / kGreatestStretch, kGreatestStretch);
      const bool is_between = distance > inside && distance < outside;
      if (std::isfinite(outside) && !is_between) distance = 0.5 * (inside + outside);
      distance = std::min(distance, room);
    }
    return std::isfinite(outside) ? value_ + side * distance : side * kInfinity;
  }

  [[nodiscard]] const Work& work() const noexcept { return work_; }

 private:
  [[nodiscard]] double straight_rise(double side) const {
    return reported_.cost(reported_.values() + side * half_width_ * direction_) - optimum_.cost;
  }

  /// Minimises the cost over all other parameters with this one held. @param others  start of the search, then its end
  [[nodiscard]] double least_cost(double held, Eigen::VectorXd& others) {
    StructureOptions structure = optimum_.structure;
    LinearPart linear = optimum_.linear;
    const std::size_t coordinates = optimum_.plain.parametrisation().coordinates().size();
    bool is_coordinate = false;
    for (std::size_t i = 0; i < coordinates; ++i) {
      const std::string& name = optimum_.parameters[i].name;
      is_coordinate = is_coordinate || name == key_.name;
      named(structure.parameters, name) = others[static_cast<Eigen::Index>(i)];
    }
    double bias_bound = optimum_.bias_bound;
    if (is_coordinate) {
      named(structure.parameters, key_.name) = held;
      for (ParameterRequest& request : structure.parameters) {
        if (request.name == key_.name) request.fixed = true;
      }
    } else if (key_.role == ParameterRole::input_bias) {
      linear.solve_bias = false;
      linear.fixed_bias = held;
      bias_bound = 0.0;
    } else if (key_.role == ParameterRole::initial_output) {
      linear.initial_output.fixed = true;
      linear.initial_output.value = held;
    } else {
      linear.numerator[key_.index].fixed = true;
      linear.numerator[key_.index].value = held;
    }
    linear.solve_ratio = linear.solve_ratio && ratio_enters_linearly(structure);
    Parametrisation parametrisation = Parametrisation::search(structure, optimum_.scale);
    if (bias_bound > 0.0) {
      named(structure.parameters, structure.structure.input_map.bias.key.name) = optimum_.solution.input_bias;
      parametrisation.add_input_bias(structure, bias_bound, 0.0);
    }
    const OutputError problem(optimum_.compared, parametrisation, linear, optimum_.noise);
    const LeastSquaresResult found = minimise(problem, parametrisation.start(), kCoarse);
    work_ += found.work;
    if (found.termination == Termination::infeasible) return kInfinity;
    const TransferFunction g = parametrisation.transfer_function(found.theta, found.point.linear.numerator);
    std::optional<ValveMap> valve = parametrisation.valve(found.theta);
    if (valve) valve->negative_gain_ratio = found.point.linear.negative_gain_ratio;
    const Eigen::VectorXd theta = Parametrisation::plain(optimum_.structure, g, valve).start();
    others.head(theta.size()) = theta;
    return found.point.cost;
  }

  const ReportedOptimum& optimum_;
  const Reported& reported_;
  ParameterKey key_;
  Interval reach_;
  double value_ = 0.0;
  Eigen::VectorXd direction_;  ///< change of the others per unit of this one
  double half_width_ = 0.0;
  double rise_ = 0.0;
  Work work_;
};

}  // namespace

Intervals intervals(const ReportedOptimum& optimum, const Uncertainty& known, const Executor& executor) {
  const Reported reported(optimum);
  const bool is_long = optimum.compared.measured().size() > kMostRows;
  const auto lost = [&](const std::string& name) {
    return std::find(known.indistinguishable.begin(), known.indistinguishable.end(), name) !=
           known.indistinguishable.end();
  };
  Intervals found;
  std::vector<Interval>& all = found.all;
  std::vector<std::size_t> bent;
  for (std::size_t i = 0; i < optimum.parameters.size(); ++i) {
    if (lost(optimum.parameters[i].name)) {
      all.push_back({-kInfinity, kInfinity});
      continue;
    }
    const Profile profile(optimum, reported, known, i);
    found.work += optimum.plain.evaluation_work(2);
    all.push_back(profile.straight());
    if (!is_long && !is_free_response(optimum.parameters[i].role) && !profile.is_straight()) bent.push_back(i);
  }
  std::vector<Work> work(2 * bent.size());
  std::vector<char> is_found(bent.size());  // not bool: each is written by a thread of its own
  executor(bent.size(), [&](std::size_t k) {
    Profile profile(optimum, reported, known, bent[k]);
    is_found[k] = profile.finds_optimum() ? 1 : 0;
    work[2 * k] = profile.work();
  });
  executor(2 * bent.size(), [&](std::size_t task) {
    if (is_found[task / 2] == 0) return;
    const std::size_t i = bent[task / 2];
    const bool is_lower = task % 2 == 0;
    Profile profile(optimum, reported, known, i);
    (is_lower ? all[i].lower : all[i].upper) = profile.end(is_lower ? -1.0 : 1.0);
    work[task] += profile.work();
  });
  for (const Work& of_end : work) found.work += of_end;
  return found;
}

}  // namespace eha::ident
