// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <exception>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "ident/estimation/ladder.hpp"

namespace eha::ident {

/// A fit from which the one behind a map is predicted.
struct PlainFit {
  std::shared_ptr<const FittedOptimum> optimum;
  double ar_bic;
  bool is_fractional;
};

/// What fits of a ladder leave behind beside their models.
struct LeftByFits {
  std::set<std::string> signatures;        ///< of the structures that were tried
  std::map<std::string, PlainFit> optima;  ///< by signature
  std::vector<Refusal> refused;
  std::exception_ptr first_failure;
  WorkByStage work;

  LeftByFits& operator+=(LeftByFits&& later);
};

/// Infinite for a model without it.
[[nodiscard]] double ar_bic(const ClimbedModel& climbed);

/// Fits and judges one structure of a ladder at a time. Thread-safe. What it is made of must outlive it.
class LadderFits {
 public:
  LadderFits(const FitOptions& options, const LadderLimits& limits, const FitStructure& fit_structure)
      : options_(options), limits_(limits), fit_structure_(fit_structure) {}

  /// The intervals of the parameters come from standard errors; the report is not complete.
  /// @param known  what it starts from @returns nothing where the record does not allow the structure
  [[nodiscard]] std::optional<ClimbedModel> fitted(const StructureOptions& asked, Search search,
                                                   const std::vector<Model>& known, LeftByFits& left) const;

  void judge_anew(ClimbedModel& climbed) const;

  /// Whether the estimating part determines what the model leaves free.
  [[nodiscard]] bool is_identified(const ClimbedModel& climbed) const;
  /// The same, whatever the uncertainty of its parameters.
  [[nodiscard]] bool is_right_but_for_parameters(const ClimbedModel& climbed) const;
  /// Of two structures of a rung, by AR-BIC: a lag that is too fast for the record must not displace the mere
  /// integrator. One that errs clearly less is preferred, whatever AR-BIC says.
  [[nodiscard]] bool is_preferred(const ClimbedModel& a, const ClimbedModel& b) const;

 private:
  const FitOptions& options_;
  const LadderLimits& limits_;
  const FitStructure& fit_structure_;
};

}  // namespace eha::ident
