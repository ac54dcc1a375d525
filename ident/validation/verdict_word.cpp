// SPDX-License-Identifier: GPL-3.0-or-later
// What a verdict is in one word, and which of its criteria failed.
#include <algorithm>
#include <cmath>

#include "ident/validation/verdict.hpp"

namespace eha::ident {

bool fails_any(const Verdict& verdict, std::initializer_list<CriterionKind> kinds) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(), [&](const Criterion& c) {
    return has_failed(c) && std::find(kinds.begin(), kinds.end(), c.kind) != kinds.end();
  });
}

std::string_view verdict_word(const Verdict& verdict) {
  const auto rejects = [](const Criterion& c) {
    return has_failed(c) && traits_of(c.kind).weight == CriterionWeight::rejects;
  };
  const auto asks_too_much = [](const Criterion& c) {
    return c.kind == CriterionKind::order_error || c.kind == CriterionKind::left_out ||
           c.kind == CriterionKind::coefficient_interval;
  };
  const auto is_unbounded = [&](const Criterion& c) {
    return rejects(c) && c.kind == CriterionKind::coefficient_interval && !std::isfinite(c.value);
  };
  const auto& all = verdict.criteria;
  const bool is_right_otherwise =
      verdict.grade == Grade::rejected && std::any_of(all.begin(), all.end(), rejects) &&
      std::all_of(all.begin(), all.end(), [&](const Criterion& c) { return !rejects(c) || asks_too_much(c); });
  if (!is_right_otherwise) return text(verdict.grade);
  return std::any_of(all.begin(), all.end(), is_unbounded) ? kNotDetermined : kNotNeeded;
}

std::string_view meaning_of(std::string_view verdict_word) {
  if (verdict_word == kNotNeeded) return "describes the record, with a parameter more than the record shows";
  if (verdict_word == kNotDetermined) {
    return "describes the record, which determines a combination of its parameters, not each of them";
  }
  return {};
}

}  // namespace eha::ident
