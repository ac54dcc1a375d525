// SPDX-License-Identifier: GPL-3.0-or-later
// What a verdict is in one word, and which of its criteria failed.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ident/validation/verdict.hpp"

namespace eha::ident {

bool fails_any(const Verdict& verdict, std::initializer_list<CriterionKind> kinds) {
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(), [&](const Criterion& c) {
    return has_failed(c) && std::find(kinds.begin(), kinds.end(), c.kind) != kinds.end();
  });
}

bool may_miss_a_part(const Verdict& verdict) {
  using Kind = CriterionKind;
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(), [](const Criterion& c) {
    const bool is_of_plant = c.kind == Kind::residual_input || c.kind == Kind::nonlinearity ||
                             c.kind == Kind::input_noise || c.kind == Kind::between_rows ||
                             c.kind == Kind::residual_drift || c.kind == Kind::error_over_estimating ||
                             c.kind == Kind::error_over_noise || c.kind == Kind::far_error_over_noise;
    return is_of_plant && !c.passed;
  });
}

bool needs_longer_record(const Verdict& verdict) {
  using Kind = CriterionKind;
  return std::any_of(verdict.criteria.begin(), verdict.criteria.end(), [](const Criterion& c) {
    return !c.judged && c.kind != Kind::input_levels && c.kind != Kind::future_input;
  });
}

std::string sight_of(const Model& model, const Verdict& verdict) {
  constexpr double kVisible_percent = 0.5;  // of the output's standard deviation
  constexpr double kClose_percent = 1.0;
  if (!model.validation || !model.validation->tests || !model.validation->tests->error) return {};
  const PredictedError& error = *model.validation->tests->error;
  const bool shows_a_part = fails_any(verdict, {CriterionKind::residual_input, CriterionKind::residual_whiteness,
                                                CriterionKind::nonlinearity, CriterionKind::error_over_noise});
  if (verdict.grade == Grade::good && error.upper >= kVisible_percent) {
    return fmt::format(
        "The grade is about what the tests can see: beside the noise of this record an error of up to {:.1g} % of the "
        "output's standard deviation would not show. A record with less noise may show one, and grade the same model "
        "usable.",
        error.upper);
  }
  if (verdict.grade == Grade::usable && shows_a_part && !needs_longer_record(verdict) &&
      error.upper <= kClose_percent) {
    return fmt::format(
        "The grade is about what the tests can see: beside the noise of this record an error of at most {:.1g} % of "
        "the output's standard deviation shows. On a noisier record the same model may be graded good.",
        error.upper);
  }
  return {};
}

std::string_view verdict_word(const Verdict& verdict) {
  const auto rejects = [](const Criterion& c) {
    return has_failed(c) && traits_of(c.kind).weight == CriterionWeight::rejects;
  };
  const auto asks_too_much = [](const Criterion& c) {
    return c.kind == CriterionKind::order_error || c.kind == CriterionKind::left_out ||
           c.kind == CriterionKind::coefficient_interval || c.kind == CriterionKind::record_length;
  };
  const auto is_unbounded = [&](const Criterion& c) {
    return rejects(c) && (c.kind == CriterionKind::record_length ||
                          (c.kind == CriterionKind::coefficient_interval && !std::isfinite(c.value)));
  };
  const auto& all = verdict.criteria;
  const bool is_right_otherwise =
      verdict.grade == Grade::rejected && verdict.error_over_recommended.value_or(1.0) <= kAsWell &&
      std::any_of(all.begin(), all.end(), rejects) &&
      std::all_of(all.begin(), all.end(), [&](const Criterion& c) { return !rejects(c) || asks_too_much(c); });
  if (!is_right_otherwise) {
    const bool is_outdone = verdict.grade != Grade::rejected && std::any_of(all.begin(), all.end(), [](const auto& c) {
                              return c.kind == CriterionKind::above_recommended && has_failed(c);
                            });
    return is_outdone ? kOutdone : text(verdict.grade);
  }
  // Without a recommended model to do as well, none is needless.
  const bool does_as_well =
      verdict.error_over_recommended && *verdict.error_over_recommended >= 1.0 / (kAsWell * kAsWell);
  const bool is_needless = does_as_well && std::none_of(all.begin(), all.end(), is_unbounded);
  return is_needless ? kNotNeeded : kNotDetermined;
}

std::string_view meaning_of(std::string_view verdict_word) {
  if (verdict_word == kNotNeeded) {
    return "describes the record as well as the recommended model, with a parameter of its own that the record does "
           "not show";
  }
  if (verdict_word == kNotDetermined) {
    return "describes the record, which does not determine each of its parameters";
  }
  if (verdict_word == kOutdone) {
    return "no check rejects it, but error and number of parameters together speak clearly for the recommended model";
  }
  return {};
}

}  // namespace eha::ident
