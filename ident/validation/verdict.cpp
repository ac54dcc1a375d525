// SPDX-License-Identifier: GPL-3.0-or-later
#include "ident/validation/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string_view>

#include "ident/fractional/stability.hpp"

namespace eha::ident {
namespace {

/// Below this p value the residual is called coloured.
constexpr double kWhitenessLevel = 0.01;

class Judgement {
 public:
  void reject(std::string_view reason) {
    accepted_ = false;
    rejections_.emplace_back(reason);
  }
  void note(std::string_view text) { notes_.emplace_back(text); }

  /// Reasons for a rejection first, then notes.
  Verdict verdict() {
    Verdict result{accepted_, std::move(rejections_)};
    result.reasons.insert(result.reasons.end(), notes_.begin(), notes_.end());
    return result;
  }

 private:
  bool accepted_ = true;
  std::vector<std::string> rejections_;
  std::vector<std::string> notes_;
};

void judge_score(const Score& score, const char* part, const Model& model, const AcceptanceLimits& limits,
                 Judgement& judgement) {
  if (!(score.r2_percent >= limits.min_validation_r2_percent)) {
    judgement.reject(fmt::format("The {} R2 of {:.4g} % is below the limit of {:.4g} %.", part, score.r2_percent,
                                 limits.min_validation_r2_percent));
  }
  const double least = std::abs(score.error_min);
  const double greatest = std::abs(score.error_max);
  const double error =
      std::isnan(greatest) ? greatest : std::max(least, greatest);  // max() would drop a NaN on its right
  // Without a limit (infinity) only a NaN fails here.
  if (!(error <= limits.max_abs_error)) {
    judgement.reject(fmt::format("The greatest {} error of {:.4g} {} is above the limit of {:.4g} {}.", part, error,
                                 model.output_unit, limits.max_abs_error, model.output_unit));
  }
}

double lowest_order(const std::vector<Term>& terms) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Term& term : terms) {
    if (term.coefficient != 0.0) lowest = std::min(lowest, term.order);
  }
  return lowest;
}

/// Whether the model would be stable without its poles at 0.
bool only_integrates(const TransferFunction& g) {
  const double poles = lowest_order(g.denominator);
  if (!(poles > lowest_order(g.numerator)) || std::isinf(poles)) return false;
  TransferFunction rest = g;
  for (Term& term : rest.denominator) term.order = std::max(0.0, term.order - poles);
  return stability(rest).stable;
}

void judge_stability(const Model& model, const AcceptanceLimits& limits, Judgement& judgement) {
  if (!model.stability) {
    if (limits.require_stable) judgement.reject("The model's stability was not determined, and the limits require it.");
    return;
  }
  const StabilityReport& stability = *model.stability;
  if (limits.require_stable && !stability.stable && only_integrates(model.transfer_function)) {
    judgement.reject(
        "The model integrates, and the limits require a stable one; [acceptance] require_stable = false of an "
        "experiment file allows it.");
  } else if (limits.require_stable && !stability.stable) {
    judgement.reject(
        fmt::format("The model is unstable (test: {}, margin {:.4g} rad), and the limits require a stable one.",
                    stability.test, stability.margin_rad));
  } else if (stability.stable && !(stability.margin_rad >= limits.min_stability_margin_rad)) {
    judgement.reject(fmt::format("The stability margin of {:.4g} rad is below the limit of {:.4g} rad.",
                                 stability.margin_rad, limits.min_stability_margin_rad));
  } else if (!stability.stable) {
    judgement.note(fmt::format("The model is unstable (test: {}, margin {:.4g} rad); the limits allow it.",
                               stability.test, stability.margin_rad));
  }
}

void note_residual(const ValidationReport& validation, const AcceptanceLimits& limits, Judgement& judgement) {
  const Correlation& ccf = validation.ccf;
  std::size_t outside = 0;
  std::size_t positive = 0;
  for (std::size_t i = 0; i < std::min(ccf.lags.size(), ccf.values.size()); ++i) {
    if (ccf.lags[i] < 1) continue;
    ++positive;
    if (std::abs(ccf.values[i]) > ccf.bound99) ++outside;
  }
  if (outside > 0) {
    judgement.note(
        fmt::format("The residual correlates with past input: {} of {} positive lags are outside the 99 % "
                    "bounds of +-{:.3g}; the model may miss a part of the plant.",
                    outside, positive, ccf.bound99));
  }
  if (validation.ljung_box_p < kWhitenessLevel && validation.acf.lags.size() > 1) {
    judgement.note(fmt::format("The residual is not white (Ljung-Box p = {:.2g} on {} lags).", validation.ljung_box_p,
                               validation.acf.lags.size() - 1));
  }
  if (validation.score.r2_percent < limits.min_validation_r2_percent && validation.offset_reestimated) {
    judgement.note(fmt::format("With the offset estimated anew on the validation part R2 is {:.4g} %.",
                               validation.offset_reestimated->r2_percent));
  }
}

/// Notes parameters whose 95 % interval is wider than twice the value. Parameters of infinite error are named
/// elsewhere.
void note_undetermined(const Model& model, Judgement& judgement) {
  for (const ParameterEstimate& p : model.parameters) {
    if (p.fixed || is_offset(p.role) || !std::isfinite(p.std)) continue;
    if (p.upper95 - p.lower95 > 2.0 * std::abs(p.value)) {
      judgement.note(fmt::format("The record hardly determines {}: its 95 % interval is {:.3g} to {:.3g}.", p.name,
                                 p.lower95, p.upper95));
    }
  }
}

}  // namespace

Verdict judge(const Model& model, const AcceptanceLimits& limits, double interpolated_percent) {
  Judgement judgement;
  if (!(interpolated_percent <= kMostInterpolated_percent)) {
    judgement.reject(
        fmt::format("{:.3g} % of the record was not measured but interpolated, which is above the limit of {:.3g} %.",
                    interpolated_percent, kMostInterpolated_percent));
  }
  if (model.estimation && !model.estimation->converged) {
    judgement.reject(fmt::format("The estimation did not converge: it ended after {} evaluations with \"{}\".",
                                 model.estimation->evaluations, model.estimation->termination));
  }
  if (model.validation) {
    judge_score(model.validation->score, "validation", model, limits, judgement);
    note_residual(*model.validation, limits, judgement);
  } else if (model.estimation) {
    judge_score(model.estimation->score, "estimation", model, limits, judgement);
    judgement.note("Nothing was kept for validation (split 1): the model is judged by the samples that estimated it.");
  } else {
    judgement.reject("The model was neither estimated nor validated here.");
  }
  judge_stability(model, limits, judgement);
  note_undetermined(model, judgement);
  return judgement.verdict();
}

}  // namespace eha::ident
