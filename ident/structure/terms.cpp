// SPDX-License-Identifier: GPL-3.0-or-later
// Structures that are given term by term.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "ident/structure/order_bounds.hpp"
#include "ident/structure/structures.hpp"

namespace eha::ident {
namespace {

constexpr std::size_t kMostTerms = 11;
constexpr double kGreatestOrder = 20.0;  // of a held term
constexpr double kSearchReach = 0.5;     // of the global search about a free order's start
constexpr double kGreatestCoefficient = 1e300;

struct Bounds {
  double lower = 0.0;
  double upper = 0.0;
};

bool by_order(const TermOptions& a, const TermOptions& b) { return a.order < b.order; }

/// Range of a term's free order between the nearest orders that are not free. Names are numbered from the lowest order,
/// so a free term and a held one must not change places.
Bounds room(const std::vector<TermOptions>& terms, const TermOptions& term, double lowest) {
  Bounds bounds{lowest, std::max(kHighestOrder, term.order + kSearchReach)};
  for (const TermOptions& other : terms) {
    if (other.free) continue;
    if (other.order < term.order) bounds.lower = std::max(bounds.lower, other.order);
    if (other.order > term.order) bounds.upper = std::min(bounds.upper, other.order);
  }
  return bounds;
}

Bounds bounds_of(const std::vector<TermOptions>& terms, const TermOptions& term, double lowest) {
  const Bounds widest = room(terms, term, lowest);
  return {term.lower.value_or(widest.lower), term.upper.value_or(widest.upper)};
}

/// Checks the terms of one polynomial.
class TermChecker {
 public:
  TermChecker(std::string list, const std::vector<TermOptions>& terms, double lowest, std::vector<TermFault>& faults)
      : list_(std::move(list)), terms_(terms), lowest_(lowest), faults_(faults) {}

  void check() {
    if (terms_.empty() || terms_.size() > kMostTerms) {
      faults_.push_back({list_, fmt::format("1 to {} terms", kMostTerms), fmt::format("{}", terms_.size())});
      return;
    }
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      check_order(k);
      check_bounds(k);
      if (const auto& held = terms_[k].coefficient; held && !(std::abs(*held) <= kGreatestCoefficient)) {
        add(k, "coefficient", "a finite number", fmt::format("{}", *held));
      }
    }
  }

 private:
  void add(std::size_t k, const char* key, std::string expected, std::string got) {
    faults_.push_back({fmt::format("{}[{}].{}", list_, k, key), std::move(expected), std::move(got)});
  }

  void check_order(std::size_t k) {
    const double order = terms_[k].order;
    if (!(order >= 0.0 && order <= kGreatestOrder)) {
      add(k, "order", fmt::format("a number from 0 to {}", kGreatestOrder), fmt::format("{}", order));
    }
    const auto same = [&](const TermOptions& other) { return std::abs(other.order - order) <= 0.0; };
    if (std::any_of(terms_.begin(), terms_.begin() + static_cast<std::ptrdiff_t>(k), same)) {
      add(k, "order", "each order once", fmt::format("{} again", order));
    }
  }

  void check_bounds(std::size_t k) {
    const TermOptions& term = terms_[k];
    if (!term.free) {
      if (term.lower) add(k, "lower", "no bound of an order that is not free", fmt::format("{}", *term.lower));
      if (term.upper) add(k, "upper", "no bound of an order that is not free", fmt::format("{}", *term.upper));
      return;
    }
    const Bounds widest = room(terms_, term, lowest_);
    if (term.lower && !(*term.lower >= widest.lower)) {
      add(k, "lower",
          fmt::format("at least {}, the next lower order that is not free or the least order", widest.lower),
          fmt::format("{}", *term.lower));
    }
    if (term.upper && !(*term.upper <= widest.upper)) {
      add(k, "upper", fmt::format("at most {}, the next higher order that is not free or the greatest", widest.upper),
          fmt::format("{}", *term.upper));
    }
    const Bounds bounds = bounds_of(terms_, term, lowest_);
    if (!(bounds.lower <= term.order && term.order <= bounds.upper)) {
      add(k, "order", fmt::format("a number from {} to {}, where this free order may be", bounds.lower, bounds.upper),
          fmt::format("{}", term.order));
    }
  }

  std::string list_;
  const std::vector<TermOptions>& terms_;
  double lowest_;
  std::vector<TermFault>& faults_;
};

/// Index of the given term with the second lowest order, whose coefficient normalisation sets to 1.
std::size_t normalised_place(const std::vector<TermOptions>& terms) {
  std::vector<std::size_t> places(terms.size());
  for (std::size_t k = 0; k < places.size(); ++k) places[k] = k;
  std::stable_sort(places.begin(), places.end(),
                   [&](std::size_t a, std::size_t b) { return by_order(terms[a], terms[b]); });
  return places[normalised_index(terms.size())];
}

StructureParameter order_parameter(ParameterKey key, const std::vector<TermOptions>& terms, const TermOptions& term,
                                   double lowest) {
  StructureParameter order{.key = std::move(key), .value = term.order};
  if (!term.free) return order;
  const Bounds bounds = bounds_of(terms, term, lowest);
  order.freedom = Freedom::free;
  order.lower = bounds.lower;
  order.upper = bounds.upper;
  order.search_lower = std::max(bounds.lower, term.order - kSearchReach);
  order.search_upper = std::min(bounds.upper, term.order + kSearchReach);
  return order;
}

StructureParameter coefficient_parameter(ParameterKey key, const TermOptions& term, bool normalised) {
  StructureParameter coefficient{.key = std::move(key), .value = 1.0, .freedom = Freedom::free};
  if (term.coefficient) {
    coefficient.value = *term.coefficient;
    coefficient.freedom = Freedom::held;
  }
  if (normalised) coefficient.freedom = Freedom::constant;
  return coefficient;
}

std::string formula_of(const TermLists& lists) {
  std::size_t free = 0;
  for (const auto* terms : {&lists.numerator, &lists.denominator}) {
    free += static_cast<std::size_t>(
        std::count_if(terms->begin(), terms->end(), [](const TermOptions& term) { return term.free; }));
  }
  return fmt::format("{} over {} terms, {} order{} free", lists.numerator.size(), lists.denominator.size(), free,
                     free == 1 ? "" : "s");
}

}  // namespace

std::vector<TermFault> faults_in_terms(const TermLists& lists) {
  std::vector<TermFault> faults;
  TermChecker("numerator", lists.numerator, 0.0, faults).check();
  TermChecker("denominator", lists.denominator, kLowestOrder, faults).check();
  if (!faults.empty()) return faults;
  const std::size_t scale = normalised_place(lists.denominator);
  if (const auto& held = lists.denominator[scale].coefficient; held && std::abs(*held - 1.0) > 0.0) {
    faults.push_back({fmt::format("denominator[{}].coefficient", scale),
                      "1 (the second lowest order of the denominator has coefficient 1)", fmt::format("{}", *held)});
  }
  const double top = std::max_element(lists.denominator.begin(), lists.denominator.end(), by_order)->order;
  for (std::size_t k = 0; k < lists.numerator.size(); ++k) {
    if (lists.numerator[k].order <= top) continue;
    faults.push_back({fmt::format("numerator[{}].order", k),
                      fmt::format("at most {}, the highest order of the denominator", top),
                      fmt::format("{}", lists.numerator[k].order)});
  }
  return faults;
}

Structure structure_of_terms(const TermLists& lists) {
  if (const auto faults = faults_in_terms(lists); !faults.empty()) {
    throw ConfigError(
        fmt::format("{}: expected {}, got {}", faults.front().place, faults.front().expected, faults.front().got));
  }
  TermLists sorted = lists;
  std::stable_sort(sorted.numerator.begin(), sorted.numerator.end(), by_order);
  std::stable_sort(sorted.denominator.begin(), sorted.denominator.end(), by_order);
  Structure structure;
  structure.family = kTermsFamily;
  structure.formula = formula_of(lists);
  const std::size_t count = sorted.numerator.size();
  for (std::size_t j = 0; j < count; ++j) {
    const TermOptions& term = sorted.numerator[j];
    structure.numerator.push_back(
        {.coefficient = coefficient_parameter(numerator_key(j, count), term, false),
         .order = order_parameter(numerator_order_key(j, count), sorted.numerator, term, 0.0)});
  }
  for (std::size_t i = 0; i < sorted.denominator.size(); ++i) {
    const TermOptions& term = sorted.denominator[i];
    const bool normalised = i == normalised_index(sorted.denominator.size());
    structure.denominator.push_back({.coefficient = coefficient_parameter(coefficient_key(i), term, normalised),
                                     .order = order_parameter(order_key(i), sorted.denominator, term, kLowestOrder)});
  }
  return structure;
}

}  // namespace eha::ident
