// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/control/feedback_design.hpp"

#include <algorithm>
#include <cmath>
#include <nlopt.hpp>
#include <numbers>

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kPoor = 1e3;           // objective where no gain keeps the limits
constexpr int kScanned = 48;            // crossovers tried before the bisection
constexpr int kBisections = 22;         // to 1e-6 of the gain
constexpr double kSafetyOfPeak = 1e-6;  // of the sensitivity, so that rounding does not exceed the limit
constexpr int kEvaluationsEach = 90;    // of a search over one shape parameter more

/// C with kp = 1 (1 / integral time for `ki`, ...), times the gain k.
struct Shape {
  FeedbackKind kind = FeedbackKind::p;
  double integral_s = 0.0;
  double derivative_s = 0.0;
  double integral_order = 1.0;
  double derivative_order = 1.0;
  double filter_s = 0.0;

  [[nodiscard]] Feedback feedback(double k) const {
    Feedback c{.kp = k, .filter_s = filter_s};
    if (integrates(kind)) {
      c.ki = k / std::pow(integral_s, integral_order);
      c.integral_order = integral_order;
    }
    if (differentiates(kind)) {
      c.kd = k * std::pow(derivative_s, derivative_order);
      c.derivative_order = derivative_order;
    }
    return c;
  }
};

class Search {
 public:
  Search(const PlantResponse& plant, const DesignLimits& limits, DesignCriterion criterion)
      : plant_(plant), limits_(limits), criterion_(criterion) {}

  /// Returns the largest gain on a shape that keeps the limits, 0: none.
  [[nodiscard]] double largest_gain(const Shape& shape) {
    const std::size_t n = plant_.w_rad_s.size();
    const Feedback one = shape.feedback(1.0);
    l_.resize(n);
    const bool whole = !(one.ki > 0.0 && one.integral_order != 1.0) && !(one.kd > 0.0 && one.derivative_order != 1.0);
    for (std::size_t i = 0; i < n; ++i) {
      const Complex s(0.0, plant_.w_rad_s[i]);
      if (whole) {
        const Complex x = s * one.filter_s;
        l_[i] = plant_.response[i] * (one.kp + one.ki / s + one.kd * s) / (1.0 + x + 0.5 * x * x);
      } else {
        l_[i] = plant_.response[i] * frequency_response(one, s);
      }
    }
    order_ = order_at_zero(plant_, one);
    // The gains whose crossover lies on the grid, the fastest first.
    double good = 0.0;
    double bad = 0.0;
    for (int i = kScanned - 1; i >= 0; --i) {
      const double size = std::abs(l_[n * static_cast<std::size_t>(i) / kScanned]);
      if (!(size > 0.0)) continue;
      const double k = 1.0 / size;
      if (keeps(shape, k)) {
        good = std::max(good, k);
        break;
      }
      bad = bad > 0.0 ? std::min(bad, k) : k;
    }
    if (good == 0.0) return 0.0;
    if (!(bad > good)) {
      bad = good * 2.0;
      for (int i = 0; i < 60 && keeps(shape, bad); ++i) {
        good = bad;
        bad *= 2.0;
      }
    }
    for (int i = 0; i < kBisections; ++i) {
      const double middle = std::sqrt(good * bad);
      (keeps(shape, middle) ? good : bad) = middle;
    }
    return good;
  }

  /// Returns the minimised quantity, on a logarithmic scale.
  [[nodiscard]] double cost(const Shape& shape) {
    const double k = largest_gain(shape);
    if (!(k > 0.0)) return kPoor;
    const Feedback c = shape.feedback(k);
    if (criterion_ == DesignCriterion::integrated_error) return -std::log(integrates(shape.kind) ? c.ki : c.kp);
    const double error = squared_load_error(plant_, c);
    return std::isfinite(error) && error > 0.0 ? std::log(error) : kPoor;
  }

 private:
  [[nodiscard]] bool keeps(const Shape& shape, double k) {
    const double s2 = 1.0 / (limits_.sensitivity * limits_.sensitivity);
    const double t2 = limits_.sensitivity * limits_.sensitivity;
    for (const Complex& l : l_) {
      const double re = 1.0 + k * l.real();
      const double im = k * l.imag();
      const double distance = re * re + im * im;
      if (distance < s2 || k * k * std::norm(l) > t2 * distance) return false;
    }
    scaled_.resize(l_.size());
    for (std::size_t i = 0; i < l_.size(); ++i) scaled_[i] = k * l_[i];
    // Stability first: if the loop gain is large everywhere, the test above passes even an unstable gain.
    if (!(sensitivity_peak(plant_.w_rad_s, scaled_, order_) <= limits_.sensitivity * (1.0 - kSafetyOfPeak)))
      return false;
    return !limits_.noise_share || !(limits_.noise_share(shape.feedback(k)) > 1.0);
  }

  const PlantResponse& plant_;
  const DesignLimits& limits_;
  DesignCriterion criterion_;
  std::vector<Complex> l_;
  std::vector<Complex> scaled_;
  double order_ = 0.0;
};

constexpr double kLeastOrder = 0.3;
constexpr double kGreatestOrder = 1.5;

Shape shape_of(FeedbackKind kind, double filter_s, const std::vector<double>& x) {
  Shape shape{.kind = kind, .filter_s = filter_s};
  std::size_t at = 0;
  if (integrates(kind)) shape.integral_s = std::exp(x.at(at++));
  if (differentiates(kind)) shape.derivative_s = std::exp(x.at(at++));
  if (kind == FeedbackKind::fopid) {
    shape.integral_order = std::clamp(x.at(at++), kLeastOrder, kGreatestOrder);
    shape.derivative_order = std::clamp(x.at(at++), kLeastOrder, kGreatestOrder);
  }
  return shape;
}

/// Starts of the search: times in units of `unit_s`.
std::vector<std::vector<double>> starts(FeedbackKind kind, double unit_s) {
  const double unit = std::log(unit_s);
  const auto times = [&](std::initializer_list<double> values) {
    std::vector<double> x;
    for (const double value : values) x.push_back(unit + std::log(value));
    return x;
  };
  switch (kind) {
    case FeedbackKind::p:
      return {{}};
    case FeedbackKind::pi:
      return {times({0.7}), times({2.5}), times({10.0})};
    case FeedbackKind::pd:
      return {times({0.1}), times({0.6})};
    case FeedbackKind::pid:
      return {times({1.5, 0.3}), times({4.0, 0.8}), times({1.5, 1.2})};
    case FeedbackKind::fopid:
      break;
  }
  return {};
}

/// Fractional orders about the best whole ones.
std::vector<std::vector<double>> starts_about(const std::vector<double>& pid) {
  std::vector<std::vector<double>> list;
  for (const auto& [integral_order, derivative_order] : {std::pair{1.0, 1.0}, {0.85, 1.15}, {1.15, 0.9}}) {
    list.push_back(pid);
    list.back().push_back(integral_order);
    list.back().push_back(derivative_order);
  }
  return list;
}

double minimised(Search& search, FeedbackKind kind, double filter_s, std::vector<double>& x) {
  if (x.empty()) return search.cost(shape_of(kind, filter_s, x));
  nlopt::opt simplex(nlopt::LN_NELDERMEAD, static_cast<unsigned>(x.size()));
  struct Context {
    Search* search;
    FeedbackKind kind;
    double filter_s;
  } context{&search, kind, filter_s};
  simplex.set_min_objective(
      [](const std::vector<double>& at, std::vector<double>&, void* data) {
        auto* c = static_cast<Context*>(data);
        return c->search->cost(shape_of(c->kind, c->filter_s, at));
      },
      &context);
  std::vector<double> step(x.size(), 0.5);
  if (kind == FeedbackKind::fopid) step[2] = step[3] = 0.15;
  simplex.set_initial_step(step);
  simplex.set_xtol_abs(1e-4);
  simplex.set_ftol_abs(1e-6);
  simplex.set_maxeval(kEvaluationsEach * static_cast<int>(x.size()));
  double least = kPoor;
  try {
    simplex.optimize(x, least);
  } catch (const nlopt::roundoff_limited&) {  // x is the best so far
    least = search.cost(shape_of(kind, filter_s, x));
  }
  return least;
}

}  // namespace

PlantResponse sampled_response(const std::function<Complex(double)>& plant, double low_rad_s, double high_rad_s,
                               double order_at_zero, int points) {
  PlantResponse result{.w_rad_s = log_grid(low_rad_s, high_rad_s, points), .order_at_zero = order_at_zero};
  for (const double w : result.w_rad_s) result.response.push_back(plant(w));
  return result;
}

std::vector<Complex> open_loop(const PlantResponse& plant, const Feedback& feedback) {
  std::vector<Complex> l;
  l.reserve(plant.w_rad_s.size());
  for (std::size_t i = 0; i < plant.w_rad_s.size(); ++i) {
    l.push_back(plant.response[i] * frequency_response(feedback, Complex(0.0, plant.w_rad_s[i])));
  }
  return l;
}

double order_at_zero(const PlantResponse& plant, const Feedback& feedback) {
  return plant.order_at_zero + (feedback.ki > 0.0 ? feedback.integral_order : 0.0);
}

double squared_load_error(const PlantResponse& plant, const Feedback& feedback) {
  // The integral is finite only with an integrating feedback of order above 0.5.
  if (!(feedback.ki > 0.0 && feedback.integral_order > 0.5)) return kInfinite;
  const std::vector<Complex> l = open_loop(plant, feedback);
  double sum = 0.0;
  double before = 0.0;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const double w = plant.w_rad_s[i];
    const double value = std::norm(plant.response[i] / (1.0 + l[i])) / w;  // per unit of ln w
    if (i > 0) sum += 0.5 * (before + value) * std::log(w / plant.w_rad_s[i - 1]);
    before = value;
  }
  return sum / std::numbers::pi;
}

std::optional<FeedbackDesign> design_feedback(FeedbackKind kind, const PlantResponse& plant, const DesignLimits& limits,
                                              double filter_s, DesignCriterion criterion) {
  if (kind == FeedbackKind::fopid) criterion = DesignCriterion::squared_error;
  if (!integrates(kind)) criterion = DesignCriterion::integrated_error;
  Search search(plant, limits, criterion);
  // The plant's time scale: where the loop with the largest proportional gain comes nearest to -1.
  double unit_s = 1.0 / std::sqrt(plant.w_rad_s.front() * plant.w_rad_s.back());
  if (const double k = search.largest_gain({.kind = FeedbackKind::p, .filter_s = filter_s}); k > 0.0) {
    const LoopMargins margins =
        loop_margins(plant.w_rad_s, open_loop(plant, {.kp = k, .filter_s = filter_s}), plant.order_at_zero);
    if (margins.ms_rad_s > 0.0) unit_s = 1.0 / margins.ms_rad_s;
  }
  double least = kPoor;
  std::vector<double> best;
  const auto try_all = [&](FeedbackKind tried, const std::vector<std::vector<double>>& all) {
    least = kPoor;
    for (std::vector<double> x : all) {
      if (const double value = minimised(search, tried, filter_s, x); value < least) {
        least = value;
        best = x;
      }
    }
    return least < kPoor;
  };
  if (kind == FeedbackKind::fopid) {
    if (!try_all(FeedbackKind::pid, starts(FeedbackKind::pid, unit_s))) return std::nullopt;
    if (!try_all(kind, starts_about(best))) return std::nullopt;
  } else if (!try_all(kind, starts(kind, unit_s))) {
    return std::nullopt;
  }
  const Shape shape = shape_of(kind, filter_s, best);
  FeedbackDesign design{.kind = kind, .feedback = shape.feedback(search.largest_gain(shape))};
  design.sensitivity =
      sensitivity_peak(plant.w_rad_s, open_loop(plant, design.feedback), order_at_zero(plant, design.feedback));
  if (limits.noise_share) design.noise_share = limits.noise_share(design.feedback);
  design.squared_error = squared_load_error(plant, design.feedback);
  return design;
}

}  // namespace eha::ident
