// SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string_view>
#include <vector>

#include "ident/export/model_formats.hpp"
#include "ident/fractional/poles.hpp"

namespace eha::ident {
namespace {

constexpr double kWholeWithin = 1e-9;
constexpr int kHighestPower = 20;
constexpr double kReal = 1e-7;  // imaginary part of a real pole, of its size
constexpr std::string_view kNotMeasured = "is not measured";

/// Coefficients of falling whole powers, or nothing where an order is not whole.
std::vector<double> falling(const std::vector<Term>& terms) {
  int highest = 0;
  for (const Term& t : terms) {
    if (std::abs(t.order - std::round(t.order)) > kWholeWithin || t.order > kHighestPower) return {};
    highest = std::max(highest, static_cast<int>(std::lround(t.order)));
  }
  std::vector<double> c(static_cast<std::size_t>(highest) + 1, 0.0);
  for (const Term& t : terms) c[static_cast<std::size_t>(highest - std::lround(t.order))] += t.coefficient;
  return c;
}

/// One section as b(s) / d(s), falling powers.
void fraction(const Section& section, std::vector<double>& numerator, std::vector<double>& denominator) {
  const std::size_t n = section.denominator.size();
  denominator = {1.0};
  numerator.clear();
  double power = 1.0;
  for (std::size_t i = 0; i < n; ++i) {
    power *= section.rate_rad_s;
    denominator.push_back(section.denominator[i] * power);
    numerator.push_back(section.numerator[i] * power);
  }
}

std::string vector(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(fmt::format("{}", value));
  return fmt::format("[{}]", fmt::join(texts, " "));
}

/// Writes a line for each pole that the record does not support, as a warning against relying on it. Whole orders.
std::string unseen_poles(const ExportedModel& model) {
  if (!model.shown_band) return {};
  constexpr double kFarOff = 3.0;  // times an end of the band; there a pole turns the phase by less than 20 degrees
  std::string text;
  const ReducedPolynomial polynomial = reduced(model.transfer_function.denominator);
  if (polynomial.terms.size() < 2) return {};  // an integrator has no other pole
  for (const std::complex<double>& pole : commensurate_roots(polynomial, 1.0)) {
    if (pole.imag() < 0.0) continue;  // the other of a pair
    const bool is_pair = pole.imag() > 0.0;
    const double f_Hz = std::abs(pole) / (2.0 * std::numbers::pi);
    const std::string which = fmt::format("% {} at {:.3g} Hz", is_pair ? "A pair of poles" : "A pole", f_Hz);
    if (f_Hz > kFarOff * model.shown_band->highest_Hz) {
      const double delay_s = (is_pair ? -2.0 : -1.0) * pole.real() / std::norm(pole);
      text += fmt::format(
          "{} is above the band that the record shows, up to {:.3g} Hz: what is measured of it\n"
          "% is its delay of {:.3g} s within the band, not its place.\n",
          which, model.shown_band->highest_Hz, delay_s);
    } else if (f_Hz < model.shown_band->lowest_Hz / kFarOff) {
      text += fmt::format(
          "{} is below the band that the record shows, from {:.3g} Hz: there the model is an\n"
          "% integrator, and a gain at standstill {}.\n",
          which, model.shown_band->lowest_Hz, kNotMeasured);
    }
  }
  return text;
}

/// "T = 0.3; % lag [s]" of each real pole (T1, T2 of several), "f0 = 2; D = 0.1;" of a pair. Whole orders.
std::string lags_and_pairs(const std::vector<Term>& denominator) {
  const ReducedPolynomial polynomial = reduced(denominator);
  if (polynomial.terms.size() < 2) return {};
  std::vector<std::string> lags;
  std::vector<std::string> pairs;
  for (const std::complex<double>& pole : commensurate_roots(polynomial, 1.0)) {
    const double size = std::abs(pole);
    if (std::abs(pole.imag()) <= kReal * size) {
      lags.push_back(fmt::format("{:.10g};  % lag [s]", -1.0 / pole.real()));
    } else if (pole.imag() > 0.0) {
      pairs.push_back(
          fmt::format("{:.10g}; D{{}} = {:.10g};  % pair of poles: frequency without damping [Hz], damping ratio",
                      size / (2.0 * std::numbers::pi), -pole.real() / size));
    }
  }
  std::string text;
  const auto add = [&](const char* name, const std::vector<std::string>& all) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const std::string number = all.size() > 1 ? fmt::format("{}", i + 1) : std::string();
      text += fmt::format("{}{} = {}\n", name, number, fmt::format(fmt::runtime(all[i]), number));
    }
  };
  add("T", lags);
  add("f0", pairs);
  return text;
}

std::string delay(double delay_s) { return delay_s > 0.0 ? fmt::format(", 'InputDelay', {}", delay_s) : ""; }

}  // namespace

std::string tf_text(const ExportedModel& model, const std::string& function) {
  std::string text =
      fmt::format("% {}: transfer function for MATLAB's Control System Toolbox; Octave: pkg load control\n", function);
  for (const std::string& line : notes(model)) text += "% " + line + "\n";
  const std::vector<double> numerator = falling(model.transfer_function.numerator);
  const std::vector<double> denominator = falling(model.transfer_function.denominator);
  if (!numerator.empty() && !denominator.empty()) {
    text += fmt::format("num = {};\nden = {};\n", vector(numerator), vector(denominator));
    text += fmt::format("{} = tf(num, den{});\n", function, delay(model.transfer_function.delay_s));
    // The gain, from the lowest power present.
    std::size_t last = denominator.size();
    while (last > 1 && denominator[last - 1] == 0.0) --last;
    const double unit = denominator[last - 1];
    const double lowest = numerator.back();
    const std::string unseen = unseen_poles(model);
    if (unit != 0.0 && lowest != 0.0) {
      text += fmt::format("K = {};  % gain{}\n", lowest / unit,
                          last < denominator.size()                        ? " of the integrator"
                          : unseen.find(kNotMeasured) != std::string::npos ? " at standstill, which is not measured"
                                                                           : " at standstill");
    }
    text += lags_and_pairs(model.transfer_function.denominator);
    text += unseen;
  } else {
    // Fractional orders: the sum of the approximation's sections over one denominator.
    std::vector<std::string> parts;
    int index = 0;
    for (const Section& section : model.sections.list) {
      std::vector<double> n;
      std::vector<double> d;
      fraction(section, n, d);
      ++index;
      text += fmt::format("g{} = tf({}, {});\n", index, vector(n), vector(d));
      parts.push_back(fmt::format("g{}", index));
    }
    if (model.sections.direct != 0.0 || parts.empty()) parts.push_back(fmt::format("{}", model.sections.direct));
    text += fmt::format("{} = {};\n", function, fmt::join(parts, " + "));
    if (model.sections.delay_s > 0.0) text += fmt::format("{}.InputDelay = {};\n", function, model.sections.delay_s);
  }
  if (model.input_map) {
    text += fmt::format("null_V = {}; dead_band_V = {}; negative_gain_ratio = {};  % of the valve before it\n",
                        model.input_map->null, model.input_map->dead_band, model.input_map->negative_gain_ratio);
  }
  return text;
}

}  // namespace eha::ident
