// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/engineering_form.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "ident/fractional/poles.hpp"
#include "ident/model/parameter_text.hpp"
#include "ident/structure/structure.hpp"

namespace eha::ident {
namespace {

constexpr double kWhole = 1e-9;           // an order is a whole number
constexpr double kItself = 1e-6;          // a figure is a parameter
constexpr double kSameGain = 0.005;       // a gain is the parameter K, beside a pole nearly at 0
constexpr double kBelowBand = 1.0 / 3.0;  // of the lowest usable frequency

/// Sorts terms by rising order and drops those of coefficient 0.
std::vector<Term> present(std::vector<Term> terms) {
  std::erase_if(terms, [](const Term& term) { return !(std::abs(term.coefficient) > 0.0); });
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return terms;
}

/// "s", "s^1.044": to the digits that are shown.
std::string seconds_text(double power) {
  const std::string digits = fmt::format("{:.4g}", power);
  return digits == "1" ? "s" : "s^" + digits;
}

/// output/input s^power: "in/(V s)", "in/V", "in s/V".
std::string gain_unit(const Model& model, double power) {
  const std::string& out = model.output_unit;
  const std::string& in = model.input_unit;
  if (out.empty() || in.empty()) return "";
  if (std::abs(power) <= kWhole) return fmt::format("{}/{}", out, in);
  const std::string seconds = seconds_text(std::abs(power));
  return power < 0.0 ? fmt::format("{}/({} {})", out, in, seconds) : fmt::format("{} {}/{}", out, seconds, in);
}

constexpr double kAboveBand = 3.0;  // times the highest usable frequency

/// " (not observed: above the band, to 0.65 Hz)" for a root far above the usable band, else empty.
/// @param is_lag  of which the band shows the delay
std::string unseen_text(const Model& model, double root_rad_s, bool is_lag = false) {
  if (!model.verdict || !model.verdict->usable_band) return {};
  const double highest_Hz = model.verdict->usable_band->highest_Hz;
  if (root_rad_s / (2.0 * std::numbers::pi) <= kAboveBand * highest_Hz) return {};
  return fmt::format(" ({}: above the band, to {:.3g} Hz)", is_lag ? "seen as a delay only" : "not observed",
                     highest_Hz);
}

/// Note for a dead time that may be a lag, else empty.
std::string or_lag_text(const Model& model) {
  if (!may_be_lag(model)) return {};
  const double highest_Hz = model.verdict->usable_band->highest_Hz;
  return fmt::format(" (or a lag of as much: the band, to {:.3g} Hz, does not tell them apart)", highest_Hz);
}

/// The first parameter of a kind; null without one.
template <typename Which>
const ParameterEstimate* parameter(const Model& model, const Which& which) {
  const auto found = std::find_if(model.parameters.begin(), model.parameters.end(), which);
  return found == model.parameters.end() ? nullptr : &*found;
}

/// A figure with half its 95 % interval or, for an empty sign, alone and rounded alike.
/// @param half_width  none, or no finite number: not known
std::string with_known(double value, std::optional<double> half_width, const std::string& otherwise,
                       std::string_view plus_minus) {
  if (!half_width || !(*half_width > 0.0) || !std::isfinite(*half_width)) return otherwise;
  if (!plus_minus.empty()) return with_half_width(value, *half_width, plus_minus);
  return *half_width > std::abs(value) ? otherwise : rounded_to(value, *half_width);
}

/// The same of an estimated parameter.
/// @param of  null: no parameter   @param factor  of the parameter, for its unit
std::string figure_text(double value, int digits, const ParameterEstimate* of, std::string_view plus_minus,
                        double factor = 1.0) {
  const bool is_known = of != nullptr && !of->fixed;
  return with_known(value, is_known ? std::optional(factor * half_width95(*of)) : std::nullopt,
                    fmt::format("{:.{}g}", value, digits), plus_minus);
}

/// The derivative of a figure by the coefficient of a term.
struct Slope {
  Term of;
  double value = 0.0;
};

/// The estimated parameter that a coefficient is, null for a held one; none where it is not known, or several have its
/// value.
std::optional<const ParameterEstimate*> coefficient_of(const Model& model, const Term& term) {
  std::optional<const ParameterEstimate*> found;
  if (std::abs(term.coefficient - 1.0) <= kWhole) found = nullptr;  // that of the normalised term
  for (const ParameterEstimate& p : model.parameters) {
    if (!is_coefficient(p.role)) continue;
    if (std::abs(p.value - term.coefficient) > kItself * std::abs(term.coefficient)) continue;
    if (found && *found != nullptr) return std::nullopt;
    found = p.fixed ? nullptr : &p;
  }
  return found;
}

/// Half the 95 % interval of a figure to first order in the errors of the coefficients; none where that is no guide, as
/// it is wider than the figure.
std::optional<double> half_width(const Model& model, double figure, const std::vector<Slope>& slopes) {
  constexpr double kRounding = 1e-6;
  std::vector<std::pair<const ParameterEstimate*, double>> free;
  for (const Slope& slope : slopes) {
    const auto of = coefficient_of(model, slope.of);
    if (!of) return std::nullopt;
    if (*of == nullptr) continue;
    if (!std::isfinite((*of)->std)) return std::nullopt;
    free.emplace_back(*of, slope.value);
  }
  double variance = 0.0;
  for (const auto& [a, by_a] : free) {
    for (const auto& [b, by_b] : free) variance += by_a * by_b * covariance(model, *a, *b);
  }
  const double half = kInterval95 * std::sqrt(std::max(0.0, variance));
  return half > kRounding * std::abs(figure) && half < std::abs(figure) ? std::optional(half) : std::nullopt;
}

/// The same of the gain, the quotient of two terms.
std::optional<double> gain_half_width(const Model& model, const Term& above, const Term& below) {
  const double gain = above.coefficient / below.coefficient;
  return half_width(model, gain, {{above, 1.0 / below.coefficient}, {below, -gain / below.coefficient}});
}

/// The same of what is made of a root. @param slope  of the figure, for a motion of the root
template <typename SlopeOf>
std::optional<double> root_half_width(const Model& model, const std::vector<Term>& terms, std::complex<double> root,
                                      double figure, const SlopeOf& slope) {
  std::complex<double> derivative = 0.0;
  for (const Term& term : terms) derivative += term.coefficient * term.order * std::pow(root, term.order - 1.0);
  if (!(std::abs(derivative) > 0.0)) return std::nullopt;
  std::vector<Slope> slopes;
  for (const Term& term : terms) slopes.push_back({term, slope(-std::pow(root, term.order) / derivative)});
  return half_width(model, figure, slopes);
}

/// "; T = 0.12 s; f0 = 2.1 Hz, D = 0.3". @param real  the name of a real root's time constant
std::string roots_text(const Model& model, const std::vector<Term>& terms, const char* real, const char* pair,
                       std::string_view plus_minus, std::optional<double> left_out_s = {}) {
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.terms.size() < 2) return {};
  std::string text;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    const double size = std::abs(root);
    const bool is_lag = std::abs(root.imag()) <= 1e-7 * size && root.real() < 0.0 && real == std::string_view("T");
    const std::string unseen = unseen_text(model, size, is_lag);
    // What the record does not show has no interval; of a lag it shows the delay.
    const bool is_seen = unseen.empty() || is_lag;
    const auto shown = [&](double figure, int digits, const auto& slope) {
      return with_known(figure, is_seen ? root_half_width(model, terms, root, figure, slope) : std::nullopt,
                        fmt::format("{:.{}g}", figure, digits), plus_minus);
    };
    if (std::abs(root.imag()) <= 1e-7 * size) {
      const double time_s = -1.0 / root.real();
      if (left_out_s && std::abs(time_s / *left_out_s - 1.0) < 1e-6) continue;
      const ParameterEstimate* itself = parameter(model, [&](const ParameterEstimate& p) {
        return !p.fixed && std::abs(p.value - time_s) <= kItself * std::abs(time_s);
      });
      text +=
          fmt::format("; {} = {} s{}", real,
                      itself != nullptr
                          ? figure_text(time_s, 4, is_seen ? itself : nullptr, plus_minus)
                          : shown(time_s, 4, [&](std::complex<double> move) { return time_s * time_s * move.real(); }),
                      unseen);
    } else if (root.imag() > 0.0) {
      const double turn = 2.0 * std::numbers::pi;
      const double damping = -root.real() / size;
      const auto of_size = [&](std::complex<double> move) { return (std::conj(root) * move).real() / size; };
      text += fmt::format(
          "; {} = {} Hz, D = {}{}", pair,
          shown(size / turn, 4, [&](std::complex<double> move) { return of_size(move) / turn; }),
          shown(damping, 3, [&](std::complex<double> move) { return (-move.real() - damping * of_size(move)) / size; }),
          unseen);
    }
  }
  return text;
}

/// Returns the time constant of a real pole so slow that the record shows an integrator instead; none if there is none.
std::optional<double> slow_pole_s(const Model& model, const std::vector<Term>& denominator) {
  if (!model.verdict || !model.verdict->usable_band) return std::nullopt;
  const ReducedPolynomial polynomial = reduced(denominator);
  if (polynomial.terms.size() < 2) return std::nullopt;
  const double slow_rad_s = kBelowBand * 2.0 * std::numbers::pi * model.verdict->usable_band->lowest_Hz;
  std::optional<double> found;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    if (std::abs(root) > slow_rad_s || std::abs(root.imag()) > 1e-7 * std::abs(root)) continue;
    if (found) return std::nullopt;
    found = -1.0 / root.real();
  }
  return found;
}

/// The time constant of a real root of the left half plane within a quarter of another one; none without.
std::optional<double> root_beside_s(const std::vector<Term>& terms, double other_s) {
  constexpr double kBeside = 1.25;  // ratio
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.terms.size() < 2) return std::nullopt;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    if (std::abs(root.imag()) > 1e-7 * std::abs(root) || !(root.real() < 0.0)) continue;
    const double ratio = -1.0 / root.real() / other_s;
    if (ratio < kBeside && ratio > 1.0 / kBeside) return -1.0 / root.real();
  }
  return std::nullopt;
}

/// "K = 0.1479 +- 0.0005", or "K/a0 = 7.6" where that is not the parameter K.
std::string gain_text(const Model& model, double gain, std::string_view plus_minus,
                      std::optional<double> half_width = {}) {
  const ParameterEstimate* k = parameter(model, [](const ParameterEstimate& p) { return p.name == "K"; });
  const bool is_other = k != nullptr && !(std::abs(gain - k->value) <= kSameGain * std::abs(k->value));
  return (is_other ? "K/a0 = " : "K = ") + with_known(gain, is_other || k == nullptr ? half_width : std::nullopt,
                                                      figure_text(gain, 4, is_other ? nullptr : k, plus_minus),
                                                      plus_minus);
}

std::string linear_text(const Model& model, std::string_view plus_minus) {
  const TransferFunction& g = model.transfer_function;
  if (!has_whole_orders(g.numerator) || !has_whole_orders(g.denominator)) return {};
  const std::vector<Term> numerator = present(g.numerator);
  const std::vector<Term> denominator = present(g.denominator);
  if (numerator.empty() || denominator.empty()) return {};
  const double power = numerator.front().order - denominator.front().order;
  const std::optional<double> slow_s = std::abs(power) <= kWhole ? slow_pole_s(model, denominator) : std::nullopt;
  const std::optional<double> beside_s = slow_s ? root_beside_s(numerator, *slow_s) : std::nullopt;
  const std::string unit = gain_unit(model, slow_s && !beside_s ? -1.0 : power);
  const double gain =
      numerator.front().coefficient / denominator.front().coefficient / slow_s.value_or(1.0) * beside_s.value_or(1.0);
  const std::optional<double> of_gain =
      slow_s ? std::nullopt : gain_half_width(model, numerator.front(), denominator.front());
  std::string text = gain_text(model, gain, plus_minus, of_gain) + (unit.empty() ? "" : " " + unit);
  if (power < -kWhole) text += power < -1.0 - kWhole ? ", integrating twice" : ", integrating";
  if (beside_s) {
    text += fmt::format(" in its band (T = {:.4g} s and TD = {:.4g} s are below it)", *slow_s, *beside_s);
  } else if (slow_s && std::abs(*slow_s) > 1.0 / kSlowestPole_rad_s) {
    text += ", integrating";
  } else if (slow_s)
    text += fmt::format(", integrating in its band (T = {:.4g} s is below it)", *slow_s);
  text += roots_text(model, denominator, "T", "f0", plus_minus, slow_s) +
          roots_text(model, numerator, "TD", "zeros at", plus_minus, beside_s);
  if (g.delay_s > 0.0) {
    const ParameterEstimate* delay =
        parameter(model, [](const ParameterEstimate& p) { return p.role == ParameterRole::delay; });
    const bool is_long = g.delay_s >= 1.0;
    const double factor = is_long ? 1.0 : 1e3;
    text += fmt::format("; dead time {} {}{}", figure_text(factor * g.delay_s, 3, delay, plus_minus, factor),
                        is_long ? "s" : "ms", or_lag_text(model));
  }
  return text;
}

std::string grey_box_unit(const Model& model, std::size_t index) {
  if (!model.grey_box || index >= model.grey_box->kind->parameters.size()) return "";
  switch (model.grey_box->kind->parameters[index].unit) {
    case GreyBoxUnit::rate_gain:
      return gain_unit(model, -1.0);
    case GreyBoxUnit::seconds:
      return "s";
    case GreyBoxUnit::input:
      return model.input_unit;
    case GreyBoxUnit::output:
      return model.output_unit;
    case GreyBoxUnit::none:
      break;
  }
  return "";
}

std::string grey_box_text(const Model& model, std::string_view plus_minus) {
  std::string text = fmt::format("{}:", model.grey_box->kind->name);
  for (std::size_t i = 0; i < model.grey_box->values.size(); ++i) {
    const std::string_view name = model.grey_box->kind->parameters[i].name;
    const ParameterEstimate* estimate = parameter(
        model, [&](const ParameterEstimate& p) { return p.role == ParameterRole::grey_box && p.name == name; });
    text += fmt::format("{} {} {}{}", i > 0 ? "," : "", name,
                        figure_text(model.grey_box->values[i], 4, estimate, plus_minus),
                        after_number(grey_box_unit(model, i)));
  }
  return text;
}

}  // namespace

bool may_be_lag(const Model& model) {
  if (!(model.transfer_function.delay_s > 0.0) || !model.verdict || !model.verdict->usable_band) return false;
  const double highest_Hz = model.verdict->usable_band->highest_Hz;
  const double delay_s = model.transfer_function.delay_s;
  const double highest_rad_s = 2.0 * std::numbers::pi * highest_Hz;
  if (highest_rad_s * kAboveBand * delay_s >= 1.0) return false;
  // The outputs of both differ as where the dead time were another one by half its square times that frequency. Steps
  // tell it, however slow most of their power is.
  constexpr double kToldApart = 5.0;  // standard errors
  const ParameterEstimate* estimate =
      parameter(model, [](const ParameterEstimate& p) { return p.role == ParameterRole::delay && !p.fixed; });
  return estimate == nullptr || !(estimate->std > 0.0) ||
         kToldApart * estimate->std > 0.5 * highest_rad_s * delay_s * delay_s;
}

std::string engineering_form(const Model& model, std::string_view plus_minus) {
  const std::string linear = linear_text(model, plus_minus);
  if (!model.grey_box) return linear;
  return grey_box_text(model, plus_minus) + (linear.empty() ? "" : "; its linear form: " + linear);
}

namespace {

/// The order of the denominator's term of a coefficient: as estimated, where its terms may stand in any order, else
/// that of so many terms from below. @param ascending  the terms by their orders
std::optional<double> denominator_order(const Model& model, const std::vector<Term>& ascending, std::size_t index) {
  const std::string name = fmt::format("n{}", index);
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role == ParameterRole::denominator_order && p.name == name) return p.value;
  }
  return index < ascending.size() ? std::optional(ascending[index].order) : std::nullopt;
}

/// The number of the coefficient that is 1: as the parameters have it, else by the structure.
std::size_t normalised_coefficient(const Model& model, std::size_t terms) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.role == ParameterRole::denominator_coefficient && p.fixed && p.value == 1.0) return key_of(p.name, 1).index;
  }
  return normalised_index(terms);
}

}  // namespace

std::string unit_of(const ParameterEstimate& parameter, const Model& model) {
  const auto by_order = [](std::vector<Term> terms) {
    std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
    return terms;
  };
  const std::vector<Term> numerator = by_order(model.transfer_function.numerator);
  const std::vector<Term> denominator = by_order(model.transfer_function.denominator);
  const std::size_t index = key_of(parameter.name, numerator.size()).index;
  const double normalised =
      denominator_order(model, denominator, normalised_coefficient(model, denominator.size())).value_or(0.0);
  switch (parameter.role) {
    case ParameterRole::numerator_coefficient:
      return index < numerator.size() ? gain_unit(model, numerator[index].order - normalised) : "";
    case ParameterRole::denominator_coefficient: {
      const std::optional<double> order = denominator_order(model, denominator, index);
      if (!order || std::abs(*order - normalised) <= kWhole) return "";
      return seconds_text(*order - normalised);
    }
    case ParameterRole::delay:
      return "s";
    case ParameterRole::grey_box:
      return grey_box_unit(model, index);
    case ParameterRole::input_bias:
    case ParameterRole::valve_null:
    case ParameterRole::dead_band:
    case ParameterRole::past_input:
      return model.input_unit;
    case ParameterRole::initial_output:
    case ParameterRole::initial_state:
      return model.output_unit;
    case ParameterRole::negative_gain_ratio:
    case ParameterRole::numerator_order:
    case ParameterRole::denominator_order:
    case ParameterRole::base_order:
      break;
  }
  return "";
}

}  // namespace eha::ident
