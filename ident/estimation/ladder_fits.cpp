// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/estimation/ladder_fits.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "ident/estimation/fitted_optimum.hpp"
#include "ident/estimation/sub_structures.hpp"

namespace eha::ident {
namespace {

constexpr const char* kRoughly = "from one start: by AR-BIC the structure cannot come near the best ones";

}  // namespace

LeftByFits& LeftByFits::operator+=(LeftByFits&& later) {
  signatures.merge(later.signatures);
  for (auto& [signature, fitted] : later.optima) optima.insert_or_assign(signature, std::move(fitted));
  std::move(later.refused.begin(), later.refused.end(), std::back_inserter(refused));
  if (!first_failure) first_failure = later.first_failure;
  add(work, later.work);
  return *this;
}

double ar_bic(const ClimbedModel& climbed) {
  const auto& information = climbed.result.model.estimation->information;
  return information ? information->ar_bic : std::numeric_limits<double>::infinity();
}

std::optional<ClimbedModel> LadderFits::fitted(const StructureOptions& asked, Search search,
                                               const std::vector<Model>& known, LeftByFits& left) const {
  FitOptions options = options_;
  options.intervals = IntervalMethod::straight;
  options.search = search;
  options.reported = Reported::estimation;
  left.signatures.insert(signature(asked));
  try {
    ClimbedModel climbed{asked, fit_structure_(asked, options, known), search == Search::nearest};
    add(left.work, climbed.result.work);
    if (climbed.is_rough) climbed.result.model.provenance["search"] = kRoughly;
    judge_anew(climbed);
    left.optima.insert_or_assign(
        signature(asked), PlainFit{climbed.result.fitted, ar_bic(climbed), has_estimated_order(climbed.result.model)});
    return climbed;
  } catch (const DataError& error) {
    if (!left.first_failure) left.first_failure = std::current_exception();
    left.refused.push_back({asked.name, error.what()});
  }
  return std::nullopt;
}

void LadderFits::judge_anew(ClimbedModel& climbed) const {
  climbed.result.model.verdict = judge(climbed.result.model, limits_.acceptance, limits_.facts);
}

bool LadderFits::is_identified(const ClimbedModel& climbed) const {
  Model unvalidated = climbed.result.model;
  unvalidated.validation.reset();
  return judge(unvalidated, limits_.acceptance, limits_.facts).accepted;
}

bool LadderFits::is_right_but_for_parameters(const ClimbedModel& climbed) const {
  ClimbedModel known = climbed;
  for (ParameterEstimate& p : known.result.model.parameters) p.fixed = true;
  return is_identified(known);
}

bool LadderFits::is_preferred(const ClimbedModel& a, const ClimbedModel& b) const {
  if (is_identified(a) != is_identified(b)) return is_identified(a);
  // An autoregressive noise may predict what a lag does, and AR-BIC then takes the structure without it.
  const auto rms = [](const ClimbedModel& climbed) { return std::sqrt(climbed.result.model.estimation->score.mse); };
  if (rms(a) > kAsWell * rms(b) || rms(b) > kAsWell * rms(a)) return rms(a) < rms(b);
  return ar_bic(a) < ar_bic(b);
}

}  // namespace eha::ident
