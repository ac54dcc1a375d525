// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "ident/acceptance_limits.hpp"
#include "ident/estimation/fit.hpp"
#include "ident/estimation/prepared_record.hpp"
#include "ident/validation/recommendation.hpp"
#include "ident/validation/verdict.hpp"

namespace eha::ident {

/// Requests for the structures of the ladder.
struct LadderOptions {
  InitialState initial_state = InitialState::automatic;
  std::vector<ParameterRequest> parameters = {};  ///< each goes to the structures that have the parameter
  Degrees io = {};                                ///< of the structure "io"
  std::optional<StructureParameter> delay = {};   ///< of all; none: estimated where the data ask for it
  const InputMapKind* input_map = nullptr;        ///< of all; null: every structure without and with each map
  Search search = Search::known;  ///< of the structures of integer order without a map; the others search globally
};

/// A structure of the ladder with its fit.
struct ClimbedModel {
  StructureOptions structure;
  FitResult result;       ///< its model has a verdict
  bool is_rough = false;  ///< fitted from one start, because it cannot be recommended
};

/// A structure that the record does not allow.
struct Refusal {
  std::string model;
  std::string reason;
};

struct Climb {
  std::vector<ClimbedModel> models;  ///< in the order of the ladder, at least one
  std::vector<Refusal> refused;
  Recommendation recommendation;
  WorkByStage work;  ///< of all fits, those of dropped models included
};

/// Limits and facts by which the models are judged.
struct LadderLimits {
  AcceptanceLimits acceptance = {};
  RecordFacts facts = {};
};

/// Fits one structure, as fit() does. The caller may measure time and show progress.
using FitStructure =
    std::function<FitResult(const StructureOptions& asked, const FitOptions& options, const std::vector<Model>& known)>;

/// Fits the structures integrator_lag (with and without its lag), cylinder, io1, io and io3 (with and without a zero),
/// lag and fo, each without and with a valve map, and recommends one. Of two forms it keeps the one that alone is
/// identified by the estimating part, otherwise one that errs clearly less, or that of lower AR-BIC. Each starts from
/// those fitted before it. Where the residual of the best depends on past input, fo is tried with a zero. A model that
/// only a coefficient compatible with 0 keeps from being identified is replaced by the structure without that
/// coefficient, which need not be on the ladder. A structure that could not come near the two best of its kind,
/// whatever map stood before it (see predicted_valve_gain()), is fitted from one start behind the map. A delay is
/// estimated where it lowers AR-BIC by 10: tried with io1 and the best structures of integer and of fractional order,
/// where predicted_delay_gain() is positive and the fit from the nearest start gains too, and with every structure
/// where one of the three is then the best of its kind. What leaving out a free order costs is taken from the ladder's
/// own models. Structures of which none lies inside the other are fitted at the same time by `executor`, below 10^6
/// rows; the answer does not depend on it. Profile intervals are computed for the recommended model and the runner-up;
/// the intervals of the others come from standard errors.
/// @param options  its intervals apply to these two
/// @throws DataError    no structure could be fitted; the reason of the first one
/// @throws ConfigError  no structure has a parameter of `wanted`, or a request for one makes no sense
/// Cost: about 20 local fits, a global search for lag and fo, and the profiles of two models.
[[nodiscard]] Climb climb(const PreparedRecord& prepared, const LadderOptions& wanted, const FitOptions& options,
                          const LadderLimits& limits, const FitStructure& fit_structure,
                          const Executor& executor = run_in_order);

}  // namespace eha::ident
