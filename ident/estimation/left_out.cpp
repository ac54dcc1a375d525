// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/left_out.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "ident/estimation/default_procedure.hpp"
#include "ident/structure/parameter_requests.hpp"

namespace eha::ident {
namespace {

/// Terms counted anew after one was erased, requests for them under their new names.
template <typename CoefficientKey, typename OrderKey>
void count_anew(StructureOptions& asked, std::vector<StructureTerm>& terms, const CoefficientKey& coefficient_of,
                const OrderKey& order_of) {
  const auto rename = [&](StructureParameter& parameter, const ParameterKey& key) {
    for (ParameterRequest& request : asked.parameters) {
      if (request.name == parameter.key.name) request.name = key.name;
    }
    parameter.key = key;
  };
  for (std::size_t i = 0; i < terms.size(); ++i) {
    rename(terms[i].coefficient, coefficient_of(i));
    rename(terms[i].order, order_of(i));
  }
}

void erase_term(StructureOptions& asked, std::vector<StructureTerm>& terms, std::size_t index) {
  const StructureTerm& term = terms[index];
  std::erase_if(asked.parameters, [&](const ParameterRequest& request) {
    return request.name == term.coefficient.key.name || request.name == term.order.key.name;
  });
  terms.erase(terms.begin() + static_cast<std::ptrdiff_t>(index));
}

}  // namespace

std::optional<StructureOptions> without_order(const StructureOptions& asked, const ParameterKey& order) {
  StructureOptions smaller = asked;
  std::vector<StructureTerm>& numerator = smaller.structure.numerator;
  std::vector<StructureTerm>& denominator = smaller.structure.denominator;
  if (order.role == ParameterRole::denominator_order) {
    if (denominator.size() < 3) return {};
    erase_term(smaller, denominator, order.index);
    count_anew(smaller, denominator, coefficient_key, order_key);
    StructureParameter& scale = denominator[normalised_index(denominator.size())].coefficient;
    scale.freedom = Freedom::constant;
    scale.value = 1.0;
    std::erase_if(smaller.parameters, [&](const ParameterRequest& request) { return request.name == scale.key.name; });
    return smaller;
  }
  if (order.role != ParameterRole::numerator_order) return {};
  if (numerator.size() > 1) {
    erase_term(smaller, numerator, order.index);
    const std::size_t terms = numerator.size();
    count_anew(
        smaller, numerator, [&](std::size_t i) { return numerator_key(i, terms); },
        [&](std::size_t i) { return numerator_order_key(i, terms); });
    return smaller;
  }
  std::erase_if(smaller.parameters, [&](const ParameterRequest& request) { return request.name == order.name; });
  numerator[0].order.freedom = Freedom::held;
  numerator[0].order.value = 0.0;
  return smaller;
}

void note_left_out(FitResult& result, const PreparedRecord& prepared, const StructureOptions& asked,
                   const FitOptions& options, const Executor& executor) {
  Model& model = result.model;
  if (!model.estimation || !model.estimation->information) return;
  FitOptions quick = options;
  quick.intervals = IntervalMethod::straight;
  double least = std::numeric_limits<double>::infinity();  // over the denominator's orders
  std::vector<LeftOut> left_out;
  std::vector<bool> of_denominator;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || !is_order(p.role)) continue;
    const auto smaller = without_order(asked, key_of(p.name, model.transfer_function.numerator.size()));
    if (!smaller) continue;
    LeftOut entry{p.name, std::numeric_limits<double>::infinity()};
    try {
      const FitResult without = fit_by_default(prepared, *smaller, quick, executor, {}, Reported::estimation);
      entry.rise = without.model.estimation->information->ar_bic - model.estimation->information->ar_bic;
    } catch (const NoStableModel&) {
      // Nothing but this term makes a model.
    }
    of_denominator.push_back(p.role == ParameterRole::denominator_order);
    if (of_denominator.back()) least = std::min(least, entry.rise);
    left_out.push_back(entry);
  }
  for (std::size_t i = 0; i < left_out.size(); ++i) {
    if (of_denominator[i]) left_out[i].rise = least;
  }
  model.estimation->information->left_out = left_out;
}

}  // namespace eha::ident
