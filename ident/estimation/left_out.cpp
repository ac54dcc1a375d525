// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/left_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "ident/estimation/default_procedure.hpp"
#include "ident/estimation/sub_structures.hpp"
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

std::optional<StructureOptions> without_coefficient(const StructureOptions& asked, const ParameterKey& coefficient) {
  StructureOptions smaller = asked;
  std::vector<StructureTerm>& numerator = smaller.structure.numerator;
  std::vector<StructureTerm>& denominator = smaller.structure.denominator;
  const std::size_t index = coefficient.index;
  if (asked.structure.base_order || !is_coefficient(coefficient.role)) return {};
  const bool is_above = coefficient.role == ParameterRole::numerator_coefficient;
  if (index >= (is_above ? numerator : denominator).size()) return {};
  if (!is_estimated(asked, (is_above ? numerator : denominator)[index].coefficient)) return {};
  const auto has_pole_at_0 = [&] { return std::abs(denominator.front().coefficient.value) <= 0.0; };
  if (is_above) {
    if (numerator.size() < 2 || (index == 0 && has_pole_at_0())) return {};
    erase_term(smaller, numerator, index);
    const std::size_t terms = numerator.size();
    count_anew(
        smaller, numerator, [&](std::size_t i) { return numerator_key(i, terms); },
        [&](std::size_t i) { return numerator_order_key(i, terms); });
  } else if (index == 0) {
    StructureParameter& lowest = denominator.front().coefficient;
    if (numerator.front().order.value > 0.0) return {};
    std::erase_if(smaller.parameters, [&](const ParameterRequest& r) { return r.name == lowest.key.name; });
    lowest.freedom = Freedom::constant;
    lowest.value = 0.0;
  } else {
    const bool is_highest = index + 1 == denominator.size();
    if (!is_highest || index < 2 || !(denominator[index - 1].order.value > numerator.back().order.value)) return {};
    erase_term(smaller, denominator, index);
  }
  smaller.structure.degrees.reset();
  smaller.structure.formula = formula_of(smaller.structure);
  return smaller;
}

void note_left_out(FitResult& result, const PreparedRecord& prepared, const StructureOptions& asked,
                   const FitOptions& options, const Executor& executor, std::vector<FittedStructure> fitted) {
  Model& model = result.model;
  if (!model.estimation || !model.estimation->information) return;
  FitOptions quick = options;
  quick.intervals = IntervalMethod::straight;
  quick.reported = Reported::score;
  double least = std::numeric_limits<double>::infinity();  // over the denominator's orders
  std::vector<LeftOut> left_out;
  std::vector<bool> of_denominator;
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || !is_order(p.role)) continue;
    const auto smaller = without_order(asked, key_of(p.name, model.transfer_function.numerator.size()));
    if (!smaller) continue;
    const std::string wanted = signature(*smaller);
    auto known = std::find_if(fitted.begin(), fitted.end(), [&](const auto& f) { return f.signature == wanted; });
    if (known == fitted.end()) {
      double ar_bic = std::numeric_limits<double>::infinity();
      try {
        const FitResult without = fit_by_default(prepared, *smaller, quick, executor, {});
        result.work["left_out"] += total(without.work);
        ar_bic = without.model.estimation->information->ar_bic;
      } catch (const NoStableModel&) {
        // Nothing but this term makes a model.
      } catch (const DataError&) {
        ar_bic = model.estimation->information->ar_bic;  // the record does not allow it, and shows no need of the term
      }
      known = fitted.insert(fitted.end(), {wanted, ar_bic});
    }
    const LeftOut entry{p.name, known->ar_bic - model.estimation->information->ar_bic};
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
