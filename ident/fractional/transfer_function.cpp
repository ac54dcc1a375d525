// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/fractional/transfer_function.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace eha::ident {
namespace {

void check_terms(const std::vector<Term>& terms, const std::string& name) {
  if (terms.empty()) throw ConfigError(name + ": expected at least one term, got none");
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const std::string where = name + "[" + std::to_string(i) + "]";
    if (!std::isfinite(terms[i].coefficient)) throw ConfigError(where + ".coefficient: expected a finite number");
    if (!(terms[i].order >= 0.0 && terms[i].order <= kOrderLimit)) {
      throw ConfigError(where + ".order: expected an order of 0 to 100, got " + std::to_string(terms[i].order));
    }
  }
}

std::complex<double> evaluate(const std::vector<Term>& terms, std::complex<double> log_s) {
  std::complex<double> sum = 0.0;
  for (const Term& term : terms) sum += term.coefficient * std::exp(term.order * log_s);
  return sum;
}

}  // namespace

bool has_whole_orders(const std::vector<Term>& terms) {
  constexpr double kWhole = 1e-9;
  return std::all_of(terms.begin(), terms.end(),
                     [](const Term& term) { return std::abs(term.order - std::round(term.order)) <= kWhole; });
}

double highest_order(const std::vector<Term>& terms) {
  double order = 0.0;
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) order = std::max(order, term.order);
  }
  return order;
}

void check(const TransferFunction& g) {
  check_terms(g.numerator, "transfer_function.numerator");
  check_terms(g.denominator, "transfer_function.denominator");
  const bool is_zero =
      std::all_of(g.denominator.begin(), g.denominator.end(), [](const Term& term) { return term.coefficient == 0.0; });
  if (is_zero) throw ConfigError("transfer_function.denominator: expected a coefficient other than 0, all are 0");
  if (!std::isfinite(g.delay_s) || g.delay_s < 0.0) {
    throw ConfigError("transfer_function.delay_s: expected a finite delay of at least 0 s");
  }
  if (highest_order(g.numerator) > highest_order(g.denominator)) {
    throw ConfigError("transfer_function.numerator: expected an order of at most the denominator's " +
                      std::to_string(highest_order(g.denominator)) + ", got " +
                      std::to_string(highest_order(g.numerator)));
  }
}

std::complex<double> frequency_response(const TransferFunction& g, std::complex<double> s) {
  const std::complex<double> log_s = std::log(s);
  return evaluate(g.numerator, log_s) / evaluate(g.denominator, log_s) * std::exp(-g.delay_s * s);
}

}  // namespace eha::ident
