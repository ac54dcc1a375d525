// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/uncertainty/bode_curve.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "ident/model/grey_box_output.hpp"
#include "ident/structure/structure.hpp"

namespace eha::ident {
namespace {

using Complex = std::complex<double>;

constexpr std::size_t kPoints = 40;
constexpr double kDifference = 1e-5;  // relative step of a difference
constexpr double kDegrees = 180.0 / std::numbers::pi;
const double kDecibels = 20.0 / std::numbers::ln10;

std::vector<Term> rising(std::vector<Term> terms) {
  std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return terms;
}

Complex value(const std::vector<Term>& terms, Complex s) {
  Complex sum = 0.0;
  for (const Term& term : terms) sum += term.coefficient * std::pow(s, term.order);
  return sum;
}

/// d ln of a polynomial by the coefficient of one term.
Complex by_coefficient(const std::vector<Term>& terms, std::size_t index, Complex s) {
  return std::pow(s, terms.at(index).order) / value(terms, s);
}

/// d ln of a polynomial by the order of one term.
Complex by_order(const std::vector<Term>& terms, std::size_t index, Complex s) {
  return terms.at(index).coefficient * std::log(s) * by_coefficient(terms, index, s);
}

/// d ln of a polynomial by the base order q that all its orders are multiples of.
Complex by_base_order(const std::vector<Term>& terms, double q, Complex s) {
  Complex sum = 0.0;
  for (const Term& term : terms) sum += term.coefficient * (term.order / q) * std::log(s) * std::pow(s, term.order);
  return sum / value(terms, s);
}

/// d ln G of the linear form of a grey box by one of its values, by a central difference.
Complex by_grey_box(const Model& model, std::size_t index, Complex s) {
  if (!model.grey_box || index >= model.grey_box->values.size()) return 0.0;
  const auto gain = [&](double by) {
    GreyBox moved = *model.grey_box;
    moved.values[index] += by;
    const TransferFunction g = linear_form(moved, 0.0);
    return value(g.numerator, s) / value(g.denominator, s);
  };
  const double step = kDifference * std::abs(model.grey_box->values[index]);
  return step > 0.0 ? std::log(gain(step) / gain(-step)) / (2.0 * step) : 0.0;
}

/// d ln G by a parameter; 0 for one that does not move G.
Complex log_derivative(const Model& model, const ParameterKey& parameter, const std::vector<Term>& numerator,
                       const std::vector<Term>& denominator, Complex s) {
  switch (parameter.role) {
    case ParameterRole::numerator_coefficient:
      return by_coefficient(numerator, parameter.index, s);
    case ParameterRole::denominator_coefficient:
      return -by_coefficient(denominator, parameter.index, s);
    case ParameterRole::numerator_order:
      return by_order(numerator, parameter.index, s);
    case ParameterRole::denominator_order:
      return -by_order(denominator, parameter.index, s);
    case ParameterRole::base_order: {
      const double q = denominator.at(normalised_index(denominator.size())).order;
      return by_base_order(numerator, q, s) - by_base_order(denominator, q, s);
    }
    case ParameterRole::delay:
      return -s;
    case ParameterRole::grey_box:
      return by_grey_box(model, parameter.index, s);
    case ParameterRole::input_bias:
    case ParameterRole::valve_null:
    case ParameterRole::dead_band:
    case ParameterRole::negative_gain_ratio:
    case ParameterRole::initial_output:
    case ParameterRole::initial_state:
    case ParameterRole::past_input:
      break;
  }
  return 0.0;
}

}  // namespace

std::vector<double> bode_frequencies(double duration_s, double compared_step_s) {
  const double low = std::log(0.5 / duration_s);
  const double high = std::log(0.5 / compared_step_s);
  std::vector<double> frequencies;
  for (std::size_t i = 0; i < kPoints; ++i) {
    frequencies.push_back(std::exp(low + (high - low) * static_cast<double>(i) / static_cast<double>(kPoints - 1)));
  }
  return frequencies;
}

GainSlope gain_slope(const Model& model, const std::vector<ParameterKey>& parameters, double frequency_Hz) {
  const std::vector<Term> numerator = rising(model.transfer_function.numerator);
  const std::vector<Term> denominator = rising(model.transfer_function.denominator);
  const Complex s(0.0, 2.0 * std::numbers::pi * frequency_Hz);
  GainSlope at;
  at.gain = value(numerator, s) / value(denominator, s) * std::exp(-s * model.transfer_function.delay_s);
  at.slope.resize(static_cast<Eigen::Index>(parameters.size()));
  for (Eigen::Index i = 0; i < at.slope.size(); ++i) {
    at.slope[i] = log_derivative(model, parameters[static_cast<std::size_t>(i)], numerator, denominator, s);
  }
  return at;
}

BodeCurve bode_curve(const Model& model, std::span<const double> frequencies_Hz, const ParameterCovariance& known) {
  const std::vector<Term> numerator = rising(model.transfer_function.numerator);
  const std::vector<Term> denominator = rising(model.transfer_function.denominator);
  BodeCurve curve;
  for (const double frequency_Hz : frequencies_Hz) {
    const Complex s(0.0, 2.0 * std::numbers::pi * frequency_Hz);
    const Complex g = value(numerator, s) / value(denominator, s);
    // The delay's part of the phase may pass many turns between two frequencies; it is known exactly.
    const double delay_deg = -s.imag() * model.transfer_function.delay_s * kDegrees;
    double phase_deg = std::arg(g) * kDegrees;
    if (!curve.phase_deg.empty()) {
      const double before_deg = curve.phase_deg.back() + 2.0 * std::numbers::pi * curve.frequency_Hz.back() *
                                                             model.transfer_function.delay_s * kDegrees;
      phase_deg -= 360.0 * std::round((phase_deg - before_deg) / 360.0);
    }
    curve.frequency_Hz.push_back(frequency_Hz);
    curve.gain_dB.push_back(kDecibels * std::log(std::abs(g)));
    curve.phase_deg.push_back(phase_deg + delay_deg);
    if (known.parameters.empty()) continue;
    Eigen::VectorXcd slope(static_cast<Eigen::Index>(known.parameters.size()));
    for (Eigen::Index i = 0; i < slope.size(); ++i) {
      slope[i] = log_derivative(model, known.parameters[static_cast<std::size_t>(i)], numerator, denominator, s);
    }
    const auto deviation = [&](const Eigen::VectorXd& by) {
      return std::sqrt(std::max(0.0, by.dot(known.matrix * by)));
    };
    curve.gain_std_dB.push_back(kDecibels * deviation(slope.real()));
    curve.phase_std_deg.push_back(kDegrees * deviation(slope.imag()));
  }
  return curve;
}

}  // namespace eha::ident
