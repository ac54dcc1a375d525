// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/model/engineering_form.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
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

bool is_whole(const std::vector<Term>& terms) {
  return std::all_of(terms.begin(), terms.end(),
                     [](const Term& term) { return std::abs(term.order - std::round(term.order)) <= kWhole; });
}

/// Sorts terms by rising order and drops those of coefficient 0.
std::vector<Term> present(std::vector<Term> terms) {
  std::erase_if(terms, [](const Term& term) { return !(std::abs(term.coefficient) > 0.0); });
  std::sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
  return terms;
}

/// output/input s^power: "in/(V s)", "in/V", "in s/V".
std::string gain_unit(const Model& model, double power) {
  const std::string& out = model.output_unit;
  const std::string& in = model.input_unit;
  if (out.empty() || in.empty()) return "";
  if (std::abs(power) <= kWhole) return fmt::format("{}/{}", out, in);
  const double size = std::abs(power);
  const std::string seconds = std::abs(size - 1.0) <= kWhole ? "s" : fmt::format("s^{:.4g}", size);
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

/// Note for a dead time that within the band has the phase of an equal lag and attenuates as little, else empty.
std::string or_lag_text(const Model& model) {
  if (!model.verdict || !model.verdict->usable_band) return {};
  const double highest_Hz = model.verdict->usable_band->highest_Hz;
  if (2.0 * std::numbers::pi * highest_Hz * kAboveBand * model.transfer_function.delay_s >= 1.0) return {};
  return fmt::format(" (or a lag of as much: the band, to {:.3g} Hz, does not tell them apart)", highest_Hz);
}

/// The first parameter of a kind; null without one.
template <typename Which>
const ParameterEstimate* parameter(const Model& model, const Which& which) {
  const auto found = std::find_if(model.parameters.begin(), model.parameters.end(), which);
  return found == model.parameters.end() ? nullptr : &*found;
}

/// A figure with half the 95 % interval of the estimated parameter that it is; else, or for an empty sign, alone.
/// @param of  null: no parameter   @param factor  of the parameter, for its unit
std::string figure_text(double value, int digits, const ParameterEstimate* of, std::string_view plus_minus,
                        double factor = 1.0) {
  const double half_width = of == nullptr || of->fixed ? 0.0 : factor * half_width95(*of);
  const bool is_shown = !plus_minus.empty() && half_width > 0.0 && std::isfinite(half_width);
  return is_shown ? with_half_width(value, half_width, plus_minus) : fmt::format("{:.{}g}", value, digits);
}

/// "; T = 0.12 s; f0 = 2.1 Hz, D = 0.3". @param real  the name of a real root's time constant
std::string roots_text(const Model& model, const std::vector<Term>& terms, const char* real, const char* pair,
                       std::string_view plus_minus, std::optional<double> left_out_s = {}) {
  const ReducedPolynomial polynomial = reduced(terms);
  if (polynomial.terms.size() < 2) return {};
  std::string text;
  for (const std::complex<double>& root : commensurate_roots(polynomial, 1.0)) {
    const double size = std::abs(root);
    if (std::abs(root.imag()) <= 1e-7 * size) {
      const double time_s = -1.0 / root.real();
      if (left_out_s && std::abs(time_s / *left_out_s - 1.0) < 1e-6) continue;
      const ParameterEstimate* itself = parameter(model, [&](const ParameterEstimate& p) {
        return !p.fixed && std::abs(p.value - time_s) <= kItself * std::abs(time_s);
      });
      text += fmt::format("; {} = {} s{}", real, figure_text(time_s, 4, itself, plus_minus),
                          unseen_text(model, size, time_s > 0.0 && real == std::string_view("T")));
    } else if (root.imag() > 0.0) {
      text += fmt::format("; {} = {:.4g} Hz, D = {:.3g}{}", pair, size / (2.0 * std::numbers::pi), -root.real() / size,
                          unseen_text(model, size));
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

/// "K = 0.1479 +- 0.0005", or "K/a0 = 7.6" where that is not the parameter K.
std::string gain_text(const Model& model, double gain, std::string_view plus_minus) {
  const ParameterEstimate* k = parameter(model, [](const ParameterEstimate& p) { return p.name == "K"; });
  const bool is_other = k != nullptr && !(std::abs(gain - k->value) <= kSameGain * std::abs(k->value));
  return (is_other ? "K/a0 = " : "K = ") + figure_text(gain, 4, is_other ? nullptr : k, plus_minus);
}

}  // namespace

std::string engineering_form(const Model& model, std::string_view plus_minus) {
  const TransferFunction& g = model.transfer_function;
  if (!is_whole(g.numerator) || !is_whole(g.denominator)) return {};
  const std::vector<Term> numerator = present(g.numerator);
  const std::vector<Term> denominator = present(g.denominator);
  if (numerator.empty() || denominator.empty()) return {};
  const double power = numerator.front().order - denominator.front().order;
  const std::optional<double> slow_s = std::abs(power) <= kWhole ? slow_pole_s(model, denominator) : std::nullopt;
  const std::string unit = gain_unit(model, slow_s ? -1.0 : power);
  const double gain = numerator.front().coefficient / denominator.front().coefficient / slow_s.value_or(1.0);
  std::string text = gain_text(model, gain, plus_minus) + (unit.empty() ? "" : " " + unit);
  if (power < -kWhole) text += power < -1.0 - kWhole ? ", integrating twice" : ", integrating";
  if (slow_s) text += fmt::format(", integrating in its band (T = {:.4g} s is below it)", *slow_s);
  text += roots_text(model, denominator, "T", "f0", plus_minus, slow_s) +
          roots_text(model, numerator, "TD", "zeros at", plus_minus);
  if (g.delay_s > 0.0) {
    const ParameterEstimate* delay =
        parameter(model, [](const ParameterEstimate& p) { return p.role == ParameterRole::delay; });
    text +=
        fmt::format("; dead time {} ms{}", figure_text(1e3 * g.delay_s, 3, delay, plus_minus, 1e3), or_lag_text(model));
  }
  return text;
}

std::string unit_of(const ParameterEstimate& parameter, const Model& model) {
  const auto by_order = [](std::vector<Term> terms) {
    std::stable_sort(terms.begin(), terms.end(), [](const Term& a, const Term& b) { return a.order < b.order; });
    return terms;
  };
  const std::vector<Term> numerator = by_order(model.transfer_function.numerator);
  const std::vector<Term> denominator = by_order(model.transfer_function.denominator);
  const std::size_t index = key_of(parameter.name, numerator.size()).index;
  const double normalised = denominator.empty() ? 0.0 : denominator[normalised_index(denominator.size())].order;
  switch (parameter.role) {
    case ParameterRole::numerator_coefficient:
      return index < numerator.size() ? gain_unit(model, numerator[index].order - normalised) : "";
    case ParameterRole::denominator_coefficient: {
      if (index >= denominator.size()) return "";
      const double power = denominator[index].order - normalised;
      if (std::abs(power) <= kWhole) return "";
      return std::abs(power - 1.0) <= kWhole ? "s" : fmt::format("s^{:.4g}", power);
    }
    case ParameterRole::delay:
      return "s";
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
